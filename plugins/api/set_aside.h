/// A list of what only the end of a run needs, one a scan say: as a vector, but that its elements may lie on
/// disk.
#pragma once

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>
#include <type_traits>

#include "api/index_iterator.h"
#include "api/scratch_file.h"

namespace loopline {

/// Elements are given by value. `T` has no pointer in it, so that its bytes are all that it is.
template <class T>
class SetAside {
    static_assert(std::is_trivially_copyable_v<T>);

 public:
    using value_type = T;

    using const_iterator = IndexIterator<SetAside>;

    /// Elements from now on go to `folder`/`name`; into memory if there is no folder. Only while it is empty.
    void keep_in(const std::filesystem::path& folder, const std::string& name) {
        if (!folder.empty()) file_.keep_in(folder / name);
    }
    /// The same for a list that is in no checkpoint.
    void keep_unseen_in(const std::filesystem::path& folder) { file_.keep_unseen_in(folder); }

    std::size_t size() const { return static_cast<std::size_t>(file_.size()); }
    bool empty() const { return size() == 0; }
    void push_back(const T& x) { file_.append(&x); }
    T operator[](std::size_t index) const {
        T x;
        std::memcpy(static_cast<void*>(&x), file_.at(index), sizeof(T));
        return x;
    }
    /// Calls `use(element)` with those from `first` up to `end`.
    template <class Use>
    void for_each(std::size_t first, std::size_t end, const Use& use) const {
        T x;
        while (first < end) {
            std::size_t together = end - first;
            const std::byte* bytes = file_.at(first, together);
            for (first += together; together > 0; --together, bytes += sizeof(T)) {
                std::memcpy(static_cast<void*>(&x), bytes, sizeof(T));
                use(x);
            }
        }
    }
    T front() const { return (*this)[0]; }
    T back() const { return (*this)[size() - 1]; }
    void set(std::size_t index, const T& x) { file_.overwrite(index, &x); }

    const_iterator begin() const { return {*this, 0}; }
    const_iterator end() const { return {*this, size()}; }

 private:
    template <class Archive, class U>
    friend void fields(Archive&, SetAside<U>&);
    ScratchFile file_{sizeof(T)};
};

template <class Archive, class T>
void fields(Archive& archive, SetAside<T>& list) {
    if constexpr (Archive::reading)
        list.file_.load(archive.archive());
    else
        list.file_.save(archive.archive(), archive.holds_everything());
}

}  // namespace loopline

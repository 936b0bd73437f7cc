/// Iterators of a list that gives its elements by value.
#pragma once

#include <cstddef>
#include <iterator>

namespace loopline {

/// Of a `List` with value_type and operator[]; for loops, and for algorithms that only read. The list
/// outlives it.
template <class List>
class IndexIterator {
 public:
    using iterator_category = std::random_access_iterator_tag;
    using value_type = typename List::value_type;
    using difference_type = std::ptrdiff_t;
    using pointer = void;
    using reference = value_type;

    IndexIterator() = default;
    IndexIterator(const List& list, std::size_t index) : list_(&list), index_(index) {}
    value_type operator*() const { return (*list_)[index_]; }
    IndexIterator& operator++() { return ++index_, *this; }
    IndexIterator operator++(int) { return {*list_, index_++}; }
    IndexIterator& operator--() { return --index_, *this; }
    IndexIterator& operator+=(std::ptrdiff_t n) {
        index_ = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(index_) + n);
        return *this;
    }
    friend IndexIterator operator+(IndexIterator i, std::ptrdiff_t n) { return i += n; }
    friend IndexIterator operator-(IndexIterator i, std::ptrdiff_t n) { return i += -n; }
    friend std::ptrdiff_t operator-(const IndexIterator& a, const IndexIterator& b) {
        return static_cast<std::ptrdiff_t>(a.index_) - static_cast<std::ptrdiff_t>(b.index_);
    }
    friend bool operator==(const IndexIterator& a, const IndexIterator& b) { return a.index_ == b.index_; }
    friend bool operator!=(const IndexIterator& a, const IndexIterator& b) { return a.index_ != b.index_; }
    friend bool operator<(const IndexIterator& a, const IndexIterator& b) { return a.index_ < b.index_; }

 private:
    const List* list_ = nullptr;
    std::size_t index_ = 0;
};

}  // namespace loopline

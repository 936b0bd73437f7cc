/// The state of a module as plain binary for a checkpoint: every number exactly as it is in memory. One
/// function a class, `fields(archive, object)`, lists what its state is, and serves for writing and reading,
/// so that the two can't differ. It stands beside the class; a class with private state makes it a friend.
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/serialization/CArchive.h>

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "api/pose2.h"
#include "api/pose3_motion.h"

namespace loopline {

/// An archive is also this if all of a state must be in it: then it refers to no file beside it.
class HoldsEverything {
 public:
    virtual ~HoldsEverything() = default;
};

/// Writes, or reads if `is_reading`. Reading throws std::exception if the bytes end early or are of another
/// form; else they are trusted, since the checksum of the checkpoint was right.
template <bool is_reading>
class StateArchive {
 public:
    static constexpr bool reading = is_reading;
    explicit StateArchive(mrpt::serialization::CArchive& archive) : archive_(archive) {}

    /// In front of a module's state: what another version wrote is refused.
    void form(const std::string& name, std::uint32_t version) {
        std::string found_name = name;
        std::uint32_t found_version = version;
        (*this)(found_name, found_version);
        if (found_name != name || found_version != version)
            throw std::runtime_error("the state of " + name + " has another form");
    }

    template <class... T>
    void operator()(T&... values) {
        (value(values), ...);
    }

    /// The elements of a vector or deque, each by `element(archive, x)`.
    template <class Container, class Element>
    void each(Container& container, const Element& element) {
        container.resize(count(container.size()));
        for (auto& x : container) element(*this, x);
    }

    bool holds_everything() const { return dynamic_cast<const HoldsEverything*>(&archive_) != nullptr; }
    /// For what MRPT itself writes and reads.
    mrpt::serialization::CArchive& archive() { return archive_; }

 private:
    void bytes(void* data, std::size_t size) {
        if (size == 0) return;
        if constexpr (reading)
            archive_.ReadBuffer(data, size);
        else
            archive_.WriteBuffer(data, size);
    }
    std::size_t count(std::size_t size) {
        std::uint64_t stored = size;
        bytes(&stored, sizeof(stored));
        return static_cast<std::size_t>(stored);
    }

    template <class T>
    void value(T& x) {
        if constexpr (std::is_same_v<T, bool>) {
            std::uint8_t byte = x ? 1 : 0;
            bytes(&byte, 1);
            x = byte != 0;
        } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
            bytes(&x, sizeof(x));
        } else {
            fields(*this, x);
        }
    }
    void value(std::string& text) {
        text.resize(count(text.size()));
        bytes(text.data(), text.size());
    }
    void value(mrpt::Clock::time_point& time) {
        auto ticks = time.time_since_epoch().count();
        value(ticks);
        time = mrpt::Clock::time_point(mrpt::Clock::duration(ticks));
    }
    template <class T, int Rows, int Columns, int Options, int MaxRows, int MaxColumns>
    void value(Eigen::Matrix<T, Rows, Columns, Options, MaxRows, MaxColumns>& m) {
        const auto rows = static_cast<Eigen::Index>(count(static_cast<std::size_t>(m.rows())));
        const auto columns = static_cast<Eigen::Index>(count(static_cast<std::size_t>(m.cols())));
        if constexpr (reading) m.resize(rows, columns);
        bytes(m.data(), static_cast<std::size_t>(m.size()) * sizeof(T));
    }
    template <class T>
    void value(std::optional<T>& x) {
        bool there = x.has_value();
        value(there);
        if (reading && there) x.emplace();
        if (!there) x.reset();
        if (there) value(*x);
    }
    template <class A, class B>
    void value(std::pair<A, B>& pair) {
        (*this)(pair.first, pair.second);
    }
    template <class T>
    void value(std::vector<T>& items) {
        each(items, [](auto& archive, T& x) { archive(x); });
    }
    template <class T>
    void value(std::deque<T>& items) {
        each(items, [](auto& archive, T& x) { archive(x); });
    }
    template <class T>
    void value(std::set<T>& items) {
        std::vector<T> list(items.begin(), items.end());
        value(list);
        if (reading) items = std::set<T>(list.begin(), list.end());
    }
    template <class Key, class T>
    void value(std::map<Key, T>& items) {
        std::vector<std::pair<Key, T>> list(items.begin(), items.end());
        value(list);
        if (reading) items = std::map<Key, T>(list.begin(), list.end());
    }
    void value(Pose2& T) { (*this)(T.x_m, T.y_m, T.phi_rad); }
    void value(Pose3& T) { (*this)(T.translation_m, T.rotation.coeffs()); }
    void value(Twist3& twist) { (*this)(twist.shift_m, twist.turn_rad); }

    mrpt::serialization::CArchive& archive_;
};

using StateWriter = StateArchive<false>;
using StateReader = StateArchive<true>;

/// Module::save_state() of a class with `fields()`.
template <class T>
void write_state(mrpt::serialization::CArchive& out, const std::string& name, std::uint32_t version,
                 const T& object) {
    StateWriter writer(out);
    writer.form(name, version);
    writer(const_cast<T&>(object));  // which writing leaves as it is
}

/// Module::load_state() of a class with `fields()`.
template <class T>
void read_state(mrpt::serialization::CArchive& in, const std::string& name, std::uint32_t version,
                T& object) {
    StateReader reader(in);
    reader.form(name, version);
    reader(object);
}

}  // namespace loopline

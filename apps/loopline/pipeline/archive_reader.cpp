#include "pipeline/archive_reader.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <new>

namespace loopline {
namespace {

constexpr std::size_t usual_object_bytes = 4096;

/// MRPT says "Stored object has class 'X' which is not registered!"; empty for any other complaint, and for a
/// name that no class could have (then the bytes are damaged).
std::string unknown_class_in(const std::string& complaint) {
    const std::string before = "Stored object has class '", after = "' which is not registered";
    const auto begin = complaint.find(before);
    if (begin == std::string::npos) return {};
    const auto end = complaint.find(after, begin);
    if (end == std::string::npos) return {};
    const std::string name = complaint.substr(begin + before.size(), end - begin - before.size());
    const bool plausible =
        name.size() > 2 && !std::isdigit(static_cast<unsigned char>(name[0])) &&
        std::all_of(name.begin(), name.end(), [](unsigned char c) {
            return std::isalnum(c) != 0 || c == '_' || c == ':' || c == '<' || c == '>' || c == ',';
        });
    return plausible ? name : std::string();
}

}  // namespace

ArchiveReader::ArchiveReader(const std::string& path, const ReadingRules& rules, std::size_t input)
    : path_(path),
      file_(path),
      archive_(file_),
      guard_(rules.state, static_cast<int>(input), file_.file_bytes()),
      limit_(input < rules.limits.size() ? rules.limits[input] : std::nullopt) {}

mrpt::serialization::CSerializable::Ptr ArchiveReader::next() {
    while (ending_ == LogEnd::not_yet) {
        if (limit_ && objects_ >= limit_->objects) return end_damaged(limit_->reason);
        if (file_.at_end()) return end_between_objects();
        if (auto object = next_known()) {
            guard_.pass(++objects_);
            return object;
        }
        guard_.enter(objects_);
        try {
            auto object = archive_.ReadObject();
            guard_.leave();
            ++objects_;
            if (object) return object;
        } catch (const std::bad_alloc&) {
            guard_.leave();
            return end_damaged("it asks for more memory than an intact log could");
        } catch (const std::exception& e) {
            guard_.leave();
            return end_inside_object(e.what());
        } catch (...) {
            guard_.leave();
            return end_damaged("its bytes make no object");
        }
    }
    return {};
}

/// The next object, if it is a whole one of the classes that need no MRPT to be read.
mrpt::serialization::CSerializable::Ptr ArchiveReader::next_known() {
    for (std::size_t wanted = usual_object_bytes, before = 0;;) {
        const std::size_t ready = file_.look_ahead(wanted);
        auto reading = known_objects_.read(file_.ready(), ready);
        if (reading.object) {
            file_.skip(reading.size);
            return std::move(reading.object);
        }
        if (reading.size <= ready || ready == before) return {};
        wanted = reading.size;
        before = ready;
    }
}

mrpt::serialization::CSerializable::Ptr ArchiveReader::end(LogEnd ending, const std::string& damage) {
    guard_.lift();
    ending_ = ending;
    damage_ = damage.empty() ? damage : path_ + ": " + damage;
    return {};
}

std::string ArchiveReader::kept() const {
    if (objects_ == 0) return "nothing of it could be read";
    return "the " + std::to_string(objects_) + (objects_ == 1 ? " object" : " objects") + " before it " +
           (objects_ == 1 ? "was" : "were") + " read, the rest is lost";
}

mrpt::serialization::CSerializable::Ptr ArchiveReader::end_between_objects() {
    switch (file_.failure()) {
        case LogFile::Failure::none:
            if (objects_ > 0) return end(LogEnd::clean, {});
            return end(LogEnd::empty, file_.file_bytes() == 0 ? "this rawlog is empty (0 bytes)"
                                                              : "this rawlog holds no object");
        case LogFile::Failure::bad_checksum:
            return end(LogEnd::checksum, "this rawlog fails its gzip checksum: all " +
                                             std::to_string(objects_) +
                                             " objects were read, but some are not what was once written");
        default:
            return end_inside_object({});
    }
}

mrpt::serialization::CSerializable::Ptr ArchiveReader::end_inside_object(const std::string& reason) {
    switch (file_.failure()) {
        case LogFile::Failure::cut_short:
            return end(LogEnd::cut_short,
                       "this rawlog is cut short in object " + std::to_string(objects_ + 1) + "; " + kept());
        case LogFile::Failure::io_error:
            return end(LogEnd::damaged, "the system fails to read this rawlog at object " +
                                            std::to_string(objects_ + 1) + "; " + kept());
        case LogFile::Failure::bad_data:
        case LogFile::Failure::bad_checksum:
            return end_damaged("its compressed bytes are not valid");
        case LogFile::Failure::none:
            break;
    }
    const std::string name = unknown_class_in(reason);
    if (!name.empty())
        return end(LogEnd::unknown_class, "object " + std::to_string(objects_ + 1) +
                                              " of this rawlog is of class " + name +
                                              ", which no loaded plugin defines: add the plugin library that "
                                              "does, unless the log is damaged there; " +
                                              kept());
    if (objects_ == 0)
        return end(LogEnd::junk, "this is not a rawlog (it doesn't begin with an MRPT object)");
    return end_damaged("its bytes make no object");
}

mrpt::serialization::CSerializable::Ptr ArchiveReader::end_damaged(const std::string& reason) {
    return end(LogEnd::damaged, "this rawlog is damaged at object " + std::to_string(objects_ + 1) + " (" +
                                    reason + "); " + kept());
}

}  // namespace loopline

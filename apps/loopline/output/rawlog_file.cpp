#include "output/rawlog_file.h"

#include "commands/command.h"

namespace loopline {

namespace fs = std::filesystem;

RawlogFile::RawlogFile(fs::path file) : file_(std::move(file)), partial_(file_.string() + ".partial") {
    bool open = false;
    try {
        open = stream_.open(partial_.string());
    } catch (const std::exception&) {
    }
    if (!open)
        throw CommandError(exit_configuration,
                           "can't write " + file_.string() +
                               "; give --out a file in a folder that exists and can be written");
}

RawlogFile::~RawlogFile() {
    stream_.close();
    std::error_code ignored;
    if (!whole_) fs::remove(partial_, ignored);
}

void RawlogFile::write(const mrpt::serialization::CSerializable& object) {
    try {
        archive_.WriteObject(object);
    } catch (const std::exception&) {
        refuse();
    }
}

void RawlogFile::commit() {
    stream_.close();
    std::error_code error;
    fs::rename(partial_, file_, error);
    if (error) refuse();
    whole_ = true;
}

void RawlogFile::refuse() {
    throw CommandError(exit_configuration, "can't write " + file_.string() + "; is the disk full?");
}

}  // namespace loopline

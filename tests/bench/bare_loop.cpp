/// The least that a program on MRPT does with a log: a bare loop over CArchive::ReadObject() on MRPT's own
/// stream. What the other benchmarks compare with, as a process of its own.
///   bare_loop LOG
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdio>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    mrpt::rtti::registerClass(CLASS_ID(mrpt::obs::CObservation2DRangeScan));  // the library must be there
    mrpt::io::CFileGZInputStream file(argv[1]);
    auto archive = mrpt::serialization::archiveFrom(file);
    std::size_t objects = 0;
    try {
        for (;; ++objects) archive.ReadObject();
    } catch (const mrpt::serialization::CExceptionEOF&) {
    }
    std::printf("%zu objects\n", objects);
}

/// MRPT objects in files that MRPT's own programs load: .gridmap, .simplemap.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <filesystem>

namespace loopline {

/// One object, serialised and compressed by gzip.
void write_mrpt_object(const std::filesystem::path& file, const mrpt::serialization::CSerializable& object);

}  // namespace loopline

/// What the writers of a run have written, and what they left out.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace loopline {

struct FileList {
    std::vector<std::string> files;     ///< relative to the run directory, in order of writing
    std::vector<std::string> warnings;  ///< sentences

    /// A file that was written, with the number of `things` that it does without because they are not finite.
    void add(const std::string& file, std::size_t left_out = 0, const std::string& things = {}) {
        files.push_back(file);
        if (left_out > 0)
            warnings.push_back(file + " leaves out " + std::to_string(left_out) + " " + things +
                               " that are not finite; the estimate or its input is damaged there");
    }
};

}  // namespace loopline

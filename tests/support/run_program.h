/// Runs a program as a user would, and keeps what it said.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/built_files.h"

extern char** environ;

namespace loopline::test {

struct ProgramResult {
    int exit_code = -1;  ///< 128 + the signal's number if a signal ended it, as in a shell
    std::string out;
    std::string err;
};

/// A new empty folder, removed with all its contents at the end of the scope.
class TemporaryFolder {
 public:
    TemporaryFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "loopline_test_XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("can't make a temporary folder");
        path_ = pattern;
    }
    ~TemporaryFolder() {
        std::error_code none;
        std::filesystem::remove_all(path_, none);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    /// Writes a file in it and returns its path.
    std::string write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
        return (path_ / name).string();
    }

 private:
    std::filesystem::path path_;
};

inline std::string file_text(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

/// Runs `words[0]` with the other words as its arguments, nothing on its standard input. `environment` is a
/// list of "NAME=value" that replace or join those of this process ("NAME" alone takes it away); `folder` is
/// its working directory if it is not empty.
inline ProgramResult run_program(const std::vector<std::string>& words,
                                 const std::vector<std::string>& environment = {},
                                 const std::filesystem::path& folder = {}) {
    const TemporaryFolder said;
    const std::string out = (said / "out").string(), err = (said / "err").string();
    // `env` sets the variables and the working directory.
    std::vector<std::string> command{"env"};
    if (!folder.empty()) command.insert(command.end(), {"-C", folder.string()});
    for (const auto& setting : environment)
        if (setting.find('=') == std::string::npos) command.insert(command.end(), {"-u", setting});
    for (const auto& setting : environment)
        if (setting.find('=') != std::string::npos) command.push_back(setting);
    command.insert(command.end(), words.begin(), words.end());
    std::vector<char*> argv;
    for (auto& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&files, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = 0;
    const int failure = posix_spawnp(&child, "env", &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (failure != 0) throw std::runtime_error("can't start " + words.front());

    int status = 0;
    while (waitpid(child, &status, 0) < 0) {
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return {code, file_text(out), file_text(err)};
}

/// The program under test.
inline ProgramResult run_loopline(std::vector<std::string> arguments,
                                  const std::vector<std::string>& environment = {},
                                  const std::filesystem::path& folder = {}) {
    arguments.insert(arguments.begin(), loopline_program());
    return run_program(arguments, environment, folder);
}

}  // namespace loopline::test

#include "sweep/child_processes.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>

#include "commands/command.h"

extern char** environ;

namespace loopline {
namespace {

pid_t started(const ChildCommand& command) {
    static const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    std::vector<std::string> words{program};
    words.insert(words.end(), command.arguments.begin(), command.arguments.end());
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, command.said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    pid_t child = 0;
    const int problem = posix_spawn(&child, program.c_str(), &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (problem != 0)
        throw CommandError(exit_configuration,
                           "no process can be started: " + std::string(std::strerror(problem)));
    return child;
}

/// Ctrl-C reaches the children by themselves; this process waits for them.
class InterruptsLeftToChildren {
 public:
    InterruptsLeftToChildren() : before_(std::signal(SIGINT, [](int) {})) {}
    ~InterruptsLeftToChildren() { std::signal(SIGINT, before_); }
    InterruptsLeftToChildren(const InterruptsLeftToChildren&) = delete;
    InterruptsLeftToChildren& operator=(const InterruptsLeftToChildren&) = delete;

 private:
    void (*before_)(int);
};

}  // namespace

std::size_t run_children(const std::vector<ChildCommand>& commands, std::size_t at_once,
                         const ChildEnded& ended, const std::function<bool()>& go_on) {
    const InterruptsLeftToChildren interrupts;
    std::map<pid_t, std::size_t> running;
    std::size_t next = 0;
    bool interrupted = false;
    for (;;) {
        while (running.size() < at_once && next < commands.size() && !interrupted && go_on()) {
            running.emplace(started(commands[next]), next);
            ++next;
        }
        if (running.empty()) return next;
        int status = 0;
        const pid_t child = ::waitpid(-1, &status, 0);
        if (child < 0 && errno != EINTR) return next;
        const auto found = running.find(child);
        if (found == running.end()) continue;
        const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        interrupted = interrupted || code == exit_interrupted;
        const std::size_t index = found->second;
        running.erase(found);
        ended(index, code);
    }
}

}  // namespace loopline

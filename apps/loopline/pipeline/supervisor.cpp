#include "pipeline/supervisor.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <iostream>
#include <new>

#include "commands/command.h"
#include "commands/interruption.h"
#include "commands/terminal.h"
#include "pipeline/archive_reader.h"

namespace loopline {
namespace {

using Stage = WorkerState::Stage;
constexpr std::chrono::milliseconds poll_interval{250};
constexpr int exit_killed = 128 + SIGKILL;
constexpr int most_workers = 12;

WorkerState* state_of_this_worker = nullptr;
void request_stop(int) {
    state_of_this_worker->stop_requested.store(true);
}

/// Memory that a worker shares with its supervisor.
class SharedState {
 public:
    SharedState() {
        void* memory =
            ::mmap(nullptr, sizeof(WorkerState), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) throw std::bad_alloc();
        state_ = new (memory) WorkerState;
    }
    ~SharedState() { ::munmap(state_, sizeof(WorkerState)); }
    SharedState(const SharedState&) = delete;
    SharedState& operator=(const SharedState&) = delete;
    WorkerState* operator->() { return state_; }
    WorkerState& operator*() { return *state_; }

 private:
    WorkerState* state_;
};

/// The signals that the supervisor waits for instead of being interrupted by them.
class AwaitedSignals {
 public:
    AwaitedSignals() {
        sigemptyset(&set_);
        for (const int signal : {SIGCHLD, SIGINT, SIGTERM}) sigaddset(&set_, signal);
        sigprocmask(SIG_BLOCK, &set_, &before_);
        // A library may have threads, which don't block them: such a thread hands its signal on.
        waiting_thread = ::pthread_self();
        struct sigaction hand_on {};
        hand_on.sa_handler = [](int signal) { ::pthread_kill(waiting_thread, signal); };
        hand_on.sa_flags = SA_RESTART;
        sigaction(SIGINT, &hand_on, &on_interrupt_before_);
        sigaction(SIGTERM, &hand_on, &on_terminate_before_);
        std::signal(SIGCHLD,
                    SIG_DFL);  // whoever started us may have ignored it, and then nothing could be waited for
    }
    ~AwaitedSignals() {
        sigaction(SIGINT, &on_interrupt_before_, nullptr);
        sigaction(SIGTERM, &on_terminate_before_, nullptr);
        release();
    }
    AwaitedSignals(const AwaitedSignals&) = delete;
    AwaitedSignals& operator=(const AwaitedSignals&) = delete;
    void release() { sigprocmask(SIG_SETMASK, &before_, nullptr); }
    /// The signal, or -1 after the time.
    int wait(std::chrono::milliseconds time) {
        const timespec timeout{time.count() / 1000, (time.count() % 1000) * 1'000'000};
        return sigtimedwait(&set_, nullptr, &timeout);
    }

 private:
    static pthread_t waiting_thread;
    sigset_t set_{}, before_{};
    struct sigaction on_interrupt_before_ {
    }, on_terminate_before_{};
};
pthread_t AwaitedSignals::waiting_thread;

/// How a worker ended.
struct Ending {
    int exit_code = 0;  ///< if it finished
    bool finished = false;
    bool hung = false;         ///< killed here since it read one object for too long
    bool interrupted = false;  ///< killed here on a second SIGINT
    int signal = 0;
};

class Supervisor {
 public:
    Supervisor(const Supervision& supervision, const std::function<int(const Attempt&)>& work)
        : supervision_(supervision), work_(work) {
        attempt_.rules.state = &*state_;
        attempt_.rules.limits.resize(supervision.rawlogs.size());
    }

    int run() {
        for (int workers = 0;; ++workers) {
            const Ending ending = run_worker(work_);
            if (ending.finished) return ending.exit_code;
            if (ending.interrupted)
                return give_up(exit_interrupted, "interrupted twice: ended at once" + unsaved());
            if (ending.signal == SIGKILL && !ending.hung)
                return give_up(exit_killed, "killed from outside (signal 9) " + place() +
                                                "; if nobody did it on purpose, memory ran out" + unsaved());
            if (workers < most_workers && limit_reading(ending)) continue;
            const std::string failure = "internal error " + place() + " (" + cause(ending) + ")",
                              lost = unsaved();
            const std::uint64_t position = state_->position;
            const bool at_an_item = state_->stage == Stage::module && position != WorkerState::at_the_end;
            const bool in_map_builder = state_->stage == Stage::map_builder;
            // Damage may have spoilt the memory long before it shows: see whether reading alone gets through.
            if (!reading_checked_ && reading_fails()) continue;
            if (at_an_item && !attempt_.stop_before_sequence) {
                attempt_.stop_before_sequence = position;
                attempt_.failure = failure + "; everything before it is kept";
            } else if (in_map_builder && !attempt_.without_maps) {
                attempt_.without_maps = true;
                attempt_.failure = failure + "; everything but the maps is kept";
            } else {
                return give_up(exit_refused, failure + lost);
            }
        }
    }

 private:
    Ending run_worker(const std::function<int(const Attempt&)>& work) {
        state_->enter(Stage::idle, 0, 0);
        state_->exception[0] = '\0';
        std::cout.flush();
        std::cerr.flush();
        const pid_t supervisor = ::getpid();
        const pid_t worker = ::fork();
        if (worker < 0)
            throw std::runtime_error("no further process can be started (" +
                                     std::string(std::strerror(errno)) + ")");
        if (worker == 0) be_worker(supervisor, work);
        return wait_for(worker);
    }

    [[noreturn]] void be_worker(pid_t supervisor, const std::function<int(const Attempt&)>& work) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != supervisor) ::_exit(exit_killed);
        state_of_this_worker = &*state_;
        struct sigaction action {};
        action.sa_handler = request_stop;
        action.sa_flags = SA_RESTART;
        sigaction(SIGINT, &action, nullptr);
        sigaction(SIGTERM, &action, nullptr);
        signals_.release();
        int code = exit_refused;
        try {
            code = work(attempt_);
            state_->stage = Stage::finished;
        } catch (const CommandError& e) {
            std::cerr << "loopline: " << e.what() << std::endl;
            code = e.code();
            state_->stage = Stage::finished;
        } catch (const std::exception& e) {
            std::strncpy(state_->exception, e.what(), sizeof(state_->exception) - 1);
        } catch (...) {
            std::strncpy(state_->exception, "an unknown exception", sizeof(state_->exception) - 1);
        }
        std::cout.flush();
        std::cerr.flush();
        ::_exit(code);  // without tearing down a hundred libraries
    }

    Ending wait_for(pid_t worker) {
        Ending ending;
        std::chrono::milliseconds in_this_read{0};
        std::uint64_t last_position = 0;
        int last_input = -1;
        for (;;) {
            const int signal = signals_.wait(poll_interval);
            if (signal == SIGINT || signal == SIGTERM) {
                // A terminal sends the first one to the worker too, whose handler has then set the same flag.
                if (interruption_.received() == Interruption::Wish::stop_at_once) {
                    ending.interrupted = true;
                    ::kill(worker, SIGKILL);
                }
                state_->stop_requested = true;
            }
            int status = 0;
            if (::waitpid(worker, &status, WNOHANG) != 0) {
                ending.finished = WIFEXITED(status) && state_->stage == Stage::finished;
                ending.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
                ending.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
                return ending;
            }
            if (signal != -1) continue;
            const bool same_read = state_->stage == Stage::reading && state_->position == last_position &&
                                   state_->index == last_input;
            in_this_read = same_read ? in_this_read + poll_interval : std::chrono::milliseconds{0};
            last_position = state_->position;
            last_input = state_->index;
            if (in_this_read < supervision_.longest_read) continue;
            ending.hung = true;
            ::kill(worker, SIGKILL);
        }
    }

    /// If the worker ended inside ReadObject(): from now on the log ends before that object.
    bool limit_reading(const Ending& ending) {
        if (state_->stage != Stage::reading) return false;
        attempt_.rules.limits[static_cast<std::size_t>(state_->index)] =
            ReadLimit{state_->position, ending.hung ? "reading it does not end" : "reading it crashes"};
        return true;
    }

    /// Reads all logs in a worker that does nothing else; true if that found damage, which is then left out.
    bool reading_fails() {
        reading_checked_ = true;
        const Ending ending = run_worker([this](const Attempt& attempt) {
            for (std::size_t i = 0; i < supervision_.rawlogs.size(); ++i) {
                ArchiveReader reader(supervision_.rawlogs[i], attempt.rules, i);
                while (!state_->stop_requested && reader.next()) {
                }
            }
            return 0;
        });
        const bool killed_from_outside = ending.signal == SIGKILL && !ending.hung;
        return !ending.finished && !killed_from_outside && limit_reading(ending);
    }

    /// "in module line_slam at observation 17"
    std::string place() {
        const auto index = static_cast<std::size_t>(state_->index.load());
        const auto name_in = [index](const std::vector<std::string>& names) {
            return index < names.size() ? names[index] : "number " + std::to_string(index + 1);
        };
        const std::uint64_t position = state_->position;
        const std::string at = position == WorkerState::at_the_end
                                   ? "after the last observation"
                                   : "at observation " + std::to_string(position);
        switch (state_->stage) {
            case Stage::module:
                return "in module " + name_in(supervision_.module_names) + " " + at;
            case Stage::map_builder:
                return "in map builder " + name_in(supervision_.map_builder_names) + " " + at;
            case Stage::writing:
                return "while writing the results";
            case Stage::drawing:
                return "while drawing the pictures";
            case Stage::reading:
                return "while reading object " + std::to_string(position + 1) + " of " +
                       name_in(supervision_.rawlogs);
            default:
                return "between two steps";
        }
    }

    std::string cause(const Ending& ending) {
        if (state_->exception[0] != '\0') {
            std::string text = state_->exception;  // MRPT's exceptions carry a call stack in further lines
            const auto line = text.find('\n');
            return text.substr(0, line);
        }
        return ending.signal != 0 ? std::string("signal ") + std::to_string(ending.signal) + ", " +
                                        ::strsignal(ending.signal)
                                  : std::string("the process ended by itself");
    }

    std::string unsaved() {
        return state_->stage == Stage::drawing ? "; everything but the pictures and the report is saved"
                                               : "; nothing of this run is saved";
    }

    int give_up(int code, const std::string& sentence) {
        clear_line_on_stderr();  // what the worker left there of its progress
        std::cerr << "loopline: " << sentence << std::endl;
        return code;
    }

    const Supervision& supervision_;
    const std::function<int(const Attempt&)>& work_;
    SharedState state_;
    AwaitedSignals signals_;
    Attempt attempt_;
    Interruption interruption_;
    bool reading_checked_ = false;
};

}  // namespace

Supervision supervision_of(const Experiment& experiment) {
    Supervision supervision;
    supervision.rawlogs = experiment.run.rawlogs;
    for (const auto& module : experiment.modules) supervision.module_names.push_back(module->info().name);
    for (const auto& builder : experiment.map_builders)
        supervision.map_builder_names.push_back(builder->info().name);
    return supervision;
}

int supervise(const Supervision& supervision, const std::function<int(const Attempt&)>& work) {
    return Supervisor(supervision, work).run();
}

}  // namespace loopline

/// What a user sees on a terminal while a run goes on: one line that rewrites itself and is gone at the end.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>

#include <csignal>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

/// Runs the program on a terminal of its own, `columns` wide; Ctrl-C is pressed `interruptions` times once
/// progress shows. Returns all that reached the screen.
test::ProgramResult run_on_terminal(const std::vector<std::string>& arguments, unsigned short columns,
                                    int interruptions) {
    const int screen = ::posix_openpt(O_RDWR | O_NOCTTY);
    EXPECT_TRUE(screen >= 0 && ::grantpt(screen) == 0 && ::unlockpt(screen) == 0);
    const winsize size{24, columns, 0, 0};
    ::ioctl(screen, TIOCSWINSZ, &size);
    const std::string terminal = ::ptsname(screen);
    const pid_t child = ::fork();
    if (child == 0) {
        ::setsid();  // the terminal that is opened next becomes this session's own
        const int line = ::open(terminal.c_str(), O_RDWR);
        for (int standard = 0; standard < 3; ++standard) ::dup2(line, standard);
        std::vector<char*> argv;
        for (const auto& word : arguments) argv.push_back(const_cast<char*>(word.c_str()));
        argv.push_back(nullptr);
        ::execv(argv[0], argv.data());
        ::_exit(127);
    }
    test::ProgramResult result;
    char bytes[4096];
    for (ssize_t count = 0; (count = ::read(screen, bytes, sizeof bytes)) > 0;) {
        result.out.append(bytes, static_cast<std::size_t>(count));
        if (result.out.find(" %") == std::string::npos) continue;
        for (; interruptions > 0; --interruptions) EXPECT_EQ(::write(screen, "\x03", 1), 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ::close(screen);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return result;
}

/// The rows that were written one over the other, of all that begin at the left margin.
std::vector<std::string> progress_rows(const std::string& screen) {
    std::vector<std::string> rows;
    for (std::size_t at = 0; (at = screen.find('\r', at)) != std::string::npos; ++at) {
        const std::string row = screen.substr(at + 1, screen.find_first_of("\r\n", at + 1) - at - 1);
        if (row.find(" %") != std::string::npos) rows.push_back(row.substr(0, row.find("\033[K")));
    }
    return rows;
}

class RunProgress : public ::testing::Test {
 protected:
    void SetUp() override {
        const int screen = ::posix_openpt(O_RDWR | O_NOCTTY);
        if (screen < 0) GTEST_SKIP() << "no pseudo-terminals here: /dev/pts is not mounted";
        ::close(screen);
    }
    /// Long enough to show progress on any machine: the real log, many times over.
    static constexpr int copies = 300;
    std::vector<std::string> arguments() const {
        std::vector<std::string> words{test::loopline_program(), "run", small_.ini(), "--out", small_.out()};
        for (int i = 0; i < copies; ++i) words.insert(words.end(), {"--rawlog", telecom_log});
        return words;
    }
    SmallRun small_{"odometry lines"};
};

}  // namespace

TEST_F(RunProgress, is_one_line_that_never_wraps_and_is_gone_at_the_end) {
    for (const unsigned short columns : {80, 40}) {
        const auto result = run_on_terminal(arguments(), columns, 0);
        EXPECT_EQ(result.exit_code, 0) << result.out;
        const auto rows = progress_rows(result.out);
        EXPECT_FALSE(rows.empty()) << result.out;
        for (const auto& row : rows) EXPECT_LT(row.size(), columns) << row;
        const auto last = result.out.rfind(" %");
        EXPECT_EQ(result.out.find("\033[K\r\033[K" + std::to_string(225 * copies) + " scans, ", last),
                  result.out.find("\033[K", last))
            << result.out;
    }
}

TEST_F(RunProgress, interrupted_it_leaves_a_clean_line) {
    const auto result = run_on_terminal(arguments(), 40, 1);
    EXPECT_EQ(result.exit_code, 130) << result.out;
    EXPECT_NE(result.out.find("^C\r\033[Kloopline: interrupted;"), std::string::npos) << result.out;
}

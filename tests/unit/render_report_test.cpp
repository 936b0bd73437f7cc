/// The report: what it must hold, that it needs nothing else, and that nothing breaks out of its text.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <regex>

#include "commands/command.h"
#include "render/render.h"
#include "render/report/html.h"
#include "render/report/run_files.h"
#include "render/report/svg_plot.h"
#include "support/run_program.h"

using namespace loopline;
namespace fs = std::filesystem;

namespace {

using test::file_text;

void write(const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

fs::path empty_folder(const std::string& name) {
    static const test::TemporaryFolder folder;
    fs::remove_all(folder / name);
    fs::create_directories(folder / name);
    return folder / name;
}

/// A run directory with everything, whose texts try to break out.
fs::path whole_run() {
    const fs::path folder = empty_folder("whole");
    std::string tum, odometry, covariance = "stamp_s,cov_x_x_m2,cov_x_y_m2,cov_y_y_m2,cov_yaw_yaw_rad2\n";
    for (int i = 0; i < 50; ++i) {
        const std::string stamp = "11378342" + std::to_string(25 + i) + ".973760000";
        tum += stamp + " " + std::to_string(i * 0.5) + " 0 0 0 0 0 1\n";
        odometry += stamp + " " + std::to_string(i * 0.5) + " " + std::to_string(i * 0.04) + " 0 0 0 0 1\n";
        covariance += stamp + "," + std::to_string(1e-4 * i) + ",0,4e-4,1e-6\n";
    }
    write(folder / "trajectory.tum", tum);
    write(folder / "odometry.tum", odometry);
    write(folder / "covariance.csv", covariance);
    write(folder / "config.ini", "[run]\n# </pre><script>alert(2)</script> & more\nmodules = odometry\n");
    write(folder / "a b#c?.txt", "x");
    write(
        folder / "metrics.json",
        R"({"status": "refused", "refused": "The estimate diverged at 12.5 s <b>here</b>.", "input_damage": "log.rawlog ends early.",
              "distance_m": 24.5, "cpu_s": 0.173, "scans_used": 50, "odd<key>": "v&v",
              "modules": {"line_slam": {"calls": 50, "mean_ms": 0.25, "worst_ms": 1.5, "finish_ms": 7.5}, "odometry": {"calls": 50, "mean_ms": 0.05, "worst_ms": 0.1}}})");
    write(
        folder / "manifest.json",
        R"({"config": "ini/real/telecom_faculty_lines.ini", "warnings": ["Stamps <i>go back</i>."], "versions": {"mrpt": "2.5.8"},
              "inputs": [{"path": "/data/\"quoted\" log.rawlog", "bytes": 1234567, "sha256": "c0ffee00", "objects_read": 450, "damage": "Cut at byte 99."}]})");
    SceneContent content;
    content.title = "Report";
    for (int i = 0; i < 50; ++i) content.estimated_path.emplace_back(Pose2{i * 0.5, 0, 0});
    content.odometry_path = content.estimated_path;
    write_snapshots(content, folder / "snapshots");
    return folder;
}

int count_of(const std::string& text, const std::string& part) {
    int count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

}  // namespace

TEST(Html, escapes_text_and_repairs_bytes) {
    EXPECT_EQ(html::escaped("<a href=\"x\">'&'</a>"),
              "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
    EXPECT_EQ(html::escaped("\u00e4\u2212\U0001F600"), "\u00e4\u2212\U0001F600");
    EXPECT_EQ(html::escaped(std::string("a\0b\x1b\xff\xc3", 6)), "a\uFFFDb\uFFFD\uFFFD\uFFFD");
    EXPECT_EQ(html::escaped("\xc0\xaf"), "\uFFFD\uFFFD") << "overlong forms are no characters";
}

TEST(Html, base64_as_in_the_rfc) {
    const char* vectors[][2] = {{"", ""},
                                {"f", "Zg=="},
                                {"fo", "Zm8="},
                                {"foo", "Zm9v"},
                                {"foob", "Zm9vYg=="},
                                {"fooba", "Zm9vYmE="},
                                {"foobar", "Zm9vYmFy"}};
    for (const auto& [plain, encoded] : vectors) EXPECT_EQ(html::base64(plain), encoded);
    EXPECT_EQ(html::base64("\xff\xfe\xfd"), "//79");
}

TEST(Html, links_and_numbers) {
    EXPECT_EQ(html::relative_link("a b/c:d#e?.txt"), "./a%20b/c%3Ad%23e%3F.txt");
    EXPECT_EQ(html::relative_link("\u00e4"), "./%C3%A4");
    EXPECT_EQ(html::number(77.0831, 3), "77.1");
    EXPECT_EQ(html::number(0.00210, 3), "0.00210");
    EXPECT_EQ(html::number(289.03, 3), "289");
    EXPECT_EQ(html::number(450), "450");
    EXPECT_EQ(html::number(-0.5, 3), "-0.500");
    EXPECT_EQ(html::number(1e-7, 3), "1e-07");
    EXPECT_EQ(html::number(std::numeric_limits<double>::quiet_NaN()), "not finite");
    EXPECT_EQ(html::file_size(999), "999 B");
    EXPECT_EQ(html::file_size(1234567), "1.23 MB");
}

TEST(SvgPlot, points_fall_where_the_axes_say_and_gaps_stay_gaps) {
    Plot plot;
    plot.title = "Test";
    plot.series = {{"estimate", {{0, 0}, {10, 5}, {std::nan(""), 1}, {20, 0}, {30, 10}}, false}};
    const std::string svg = svg_plot(plot);
    // x from 0 to 30 over 52..468, y from 0 to 10 widened by 6 % over 214..26.
    std::smatch found;
    ASSERT_TRUE(std::regex_search(
        svg, found, std::regex(R"re(class="estimate" d="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)M([\d.]+) )re")));
    EXPECT_NEAR(std::stod(found[1]), 52, 0.11);
    EXPECT_NEAR(std::stod(found[2]), 214 - (0 + 0.3) / 10.6 * 188, 0.11);
    EXPECT_NEAR(std::stod(found[3]), 52 + 416 / 3.0, 0.11);
    EXPECT_NEAR(std::stod(found[4]), 214 - (5 + 0.3) / 10.6 * 188, 0.11);
    EXPECT_NEAR(std::stod(found[5]), 52 + 416 * 2 / 3.0, 0.11);
    EXPECT_EQ(svg_plot({}), "");
    plot.series = {{"estimate", {{std::nan(""), 0}}, false}};
    EXPECT_EQ(svg_plot(plot), "");
    plot.series = {{"estimate", {{1e15, -3}}, false}};
    EXPECT_EQ(count_of(svg_plot(plot), "nan"), 0) << "one point, far out";
}

TEST(SvgPlot, equal_scale_keeps_a_square_square) {
    Plot plot;
    plot.equal_scale = true;
    plot.series = {{"estimate", {{0, 0}, {4, 0}, {4, 4}, {0, 4}}, false}};
    std::smatch found;
    const std::string svg = svg_plot(plot);
    ASSERT_TRUE(std::regex_search(
        svg, found,
        std::regex(R"re(class="estimate" d="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+))re")));
    EXPECT_NEAR(std::stod(found[3]) - std::stod(found[1]), std::stod(found[4]) - std::stod(found[6]), 0.3);
}

TEST(SvgPlot, thinning_a_signal_keeps_its_peak) {
    std::vector<Eigen::Vector2d> signal;
    for (int i = 0; i < 100'000; ++i) signal.push_back({double(i), std::sin(i * 0.001)});
    signal[77'777].y() = 9;
    const auto kept = thinned_signal(signal, 800);
    EXPECT_LE(kept.size(), 800u);
    double peak = 0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        peak = std::max(peak, kept[i].y());
        if (i > 0) {
            EXPECT_LT(kept[i - 1].x(), kept[i].x());
        }
    }
    EXPECT_EQ(peak, 9);
}

TEST(Report, holds_what_it_must) {
    const fs::path folder = whole_run();
    write_report(folder);
    const std::string page = file_text(folder / "report.html");
    for (const char* part : {"<h1>telecom_faculty_lines",
                             "Refused",
                             "The estimate diverged at 12.5 s &lt;b&gt;here&lt;/b&gt;.",
                             "log.rawlog ends early.",
                             "Stamps &lt;i&gt;go back&lt;/i&gt;.",
                             "24.5 <small>m</small>",
                             "distance travelled",
                             "0.173 <small>s</small>",
                             "2006-01-21 09:",
                             "odd&lt;key&gt;",
                             "v&amp;v",
                             "line_slam",
                             "<td>20</td>",
                             "/data/&quot;quoted&quot; log.rawlog",
                             "c0ffee00",
                             "Cut at byte 99.",
                             "1.23 MB",
                             "&lt;/pre&gt;&lt;script&gt;alert(2)&lt;/script&gt; &amp; more",
                             "href=\"./trajectory.tum\"",
                             "href=\"./a%20b%23c%3F.txt\"",
                             "prefers-color-scheme: dark",
                             "@media print",
                             "name=\"viewport\""})
        EXPECT_NE(page.find(part), std::string::npos) << part;
    EXPECT_GE(count_of(page, "data:image/png;base64,"), 2);
    EXPECT_EQ(count_of(page, "<svg "), 6) << "trajectory, two differences, three deviations";
    // 1.96 m apart at the end: the last tile and the last point of the curve.
    EXPECT_NE(page.find("1.96 <small>m</small>"), std::string::npos);
}

TEST(Report, needs_nothing_else) {
    const fs::path folder = whole_run();
    write_report(folder);
    const std::string page = file_text(folder / "report.html");
    EXPECT_EQ(count_of(page, "<script"), 0);
    EXPECT_EQ(count_of(page, "http://"), 0);
    EXPECT_EQ(count_of(page, "https://"), 0);
    EXPECT_EQ(count_of(page, "url("), 0);
    EXPECT_EQ(count_of(page, "@import"), 0);
    EXPECT_EQ(count_of(page, "<link"), 0);
    const std::regex source("src=\"(.{5})");
    for (std::sregex_iterator it(page.begin(), page.end(), source), end; it != end; ++it)
        EXPECT_EQ((*it)[1], "data:");
    EXPECT_LT(page.size(), 3'000'000u);
    // Every link leads to a file that is there.
    const std::regex link("href=\"([^\"]*)\"");
    int links = 0;
    for (std::sregex_iterator it(page.begin(), page.end(), link), end; it != end; ++it, ++links) {
        std::string target = (*it)[1];
        EXPECT_EQ(target.rfind("./", 0), 0u) << target;
        for (std::size_t at; (at = target.find('%')) != std::string::npos;)
            target.replace(at, 3, 1, static_cast<char>(std::stoi(target.substr(at + 1, 2), nullptr, 16)));
        EXPECT_TRUE(fs::exists(folder / target)) << target;
    }
    EXPECT_GT(links, 6);
    write_report(folder);
    EXPECT_TRUE(page == file_text(folder / "report.html")) << "same run, same bytes";
}

TEST(Report, tags_are_balanced) {
    const fs::path folder = whole_run();
    write_report(folder);
    const std::string page = file_text(folder / "report.html");
    std::vector<std::string> open;
    int tags = 0;
    for (std::size_t at = page.find("<body>"); (at = page.find('<', at)) != std::string::npos; ++tags) {
        const std::size_t end = page.find('>', at);
        ASSERT_NE(end, std::string::npos);
        const bool is_end = page[at + 1] == '/', is_single = page[end - 1] == '/';
        const std::size_t name_at = at + (is_end ? 2 : 1);
        const std::string name = page.substr(name_at, page.find_first_of(" />", name_at) - name_at);
        at = end;
        if (name == "html" || name == "img" || is_single) continue;
        if (!is_end) {
            open.push_back(name);
            continue;
        }
        ASSERT_FALSE(open.empty()) << name;
        ASSERT_EQ(open.back(), name);
        open.pop_back();
    }
    EXPECT_TRUE(open.empty());
    EXPECT_GT(tags, 100);
}

TEST(Report, loops_and_corrections_in_their_order) {
    const fs::path folder = empty_folder("loops");
    write(folder / "metrics.json",
          R"({"status": "done", "loops": [
              {"stamp_s": 62.51, "old_stamp_s": 4.26, "way_m": 41.5, "score": 0.754, "rival_score": 0.25, "shift_m": 0.4215,
               "shift_deg": -1.3, "decision": "accepted", "reason": "two matches <agree>"},
              {"stamp_s": 70, "decision": "refused", "reason": "a rival"}, {"decision": "waits"}, 7]})");
    fs::create_directories(folder / "snapshots");
    SceneContent content;
    for (const char* name : {"top.png", "correction_10.png", "correction_2.png"})
        render_picture(content, View::top, {200, 150}, folder / "snapshots" / name);
    write(folder / "snapshots/correction_3.png", "no picture");
    write_report(folder);
    const std::string page = file_text(folder / "report.html");
    for (const char* part :
         {"<h2>Loops</h2>", "<td>62.5</td><td>4.3</td><td>41.5</td>", "\u22121.30</td>", "accepted</span>",
          "two matches &lt;agree&gt;", "refused</span>", "a rival", "waits</span>"})
        EXPECT_NE(page.find(part), std::string::npos) << part;
    const auto second = page.find("Correction 2: "), tenth = page.find("Correction 10: ");
    ASSERT_NE(second, std::string::npos);
    ASSERT_NE(tenth, std::string::npos);
    EXPECT_LT(second, tenth);
    EXPECT_GT(second, page.find("<h2>Loops</h2>"));
    EXPECT_EQ(count_of(page, "data:image/png"), 3) << "each picture once";
}

TEST(Report, many_refused_loops_are_folded_away) {
    const fs::path folder = empty_folder("many_loops");
    std::string loops;
    for (int i = 0; i < 30; ++i)
        loops += std::string(i > 0 ? "," : "") + R"({"stamp_s": 1, "decision": ")" +
                 (i % 10 == 0 ? "accepted" : "refused") + "\"}";
    write(folder / "metrics.json", R"({"loops": [)" + loops + "]}");
    write_report(folder);
    const std::string page = file_text(folder / "report.html");
    const auto fold = page.find("<details><summary>27 more places");
    ASSERT_NE(fold, std::string::npos);
    EXPECT_EQ(count_of(page.substr(0, fold), "accepted</span>"), 3);
    EXPECT_EQ(count_of(page.substr(fold), "refused</span>"), 27);
}

TEST(Report, without_loops_there_is_no_section) {
    const fs::path folder = whole_run();
    write_report(folder);
    EXPECT_EQ(count_of(file_text(folder / "report.html"), "<h2>Loops</h2>"), 0);
}

TEST(Report, an_empty_or_damaged_run_still_gets_a_page) {
    const fs::path empty = empty_folder("empty");
    write_report(empty);
    EXPECT_NE(file_text(empty / "report.html").find("metrics.json is missing"), std::string::npos);
    const fs::path damaged = empty_folder("damaged");
    fs::create_directories(damaged / "snapshots");
    write(damaged / "metrics.json", "{\"status\": 3, \"modules\": [1], \"distance_m\": \"far\"");
    write(damaged / "manifest.json",
          "{\"inputs\": [1, {\"path\": 2}], \"warnings\": {\"a\": 1}, \"config\": 5}");
    write(damaged / "trajectory.tum", "not a pose\n");
    write(damaged / "covariance.csv", "a,b\n1,2\n");
    write(damaged / "snapshots/top.png", "no picture");
    write_report(damaged);
    EXPECT_GT(file_text(damaged / "report.html").size(), 3000u);
}

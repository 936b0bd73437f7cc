/// Tables and the words of a column map: what they say, and what is wrong with them.
#include <gtest/gtest.h>

#include <cmath>

#include "importers/csv_table.h"
#include "support/csv_import.h"

using namespace loopline;
using namespace loopline::csv;
using test::CsvImport;

TEST(CsvColumns, say_name_unit_and_factor) {
    const auto parsed = column_from_text("a wheel in deg times -1", Quantity::angle);
    EXPECT_EQ(parsed.problem, "");
    EXPECT_EQ(parsed.choice.name, "a wheel");
    EXPECT_DOUBLE_EQ(parsed.choice.factor, -M_PI / 180);
    EXPECT_EQ(column_from_text("\"speed in town\" in km/h", Quantity::speed).choice.name, "speed in town");
    EXPECT_DOUBLE_EQ(column_from_text("v in km/h", Quantity::speed).choice.factor, 1 / 3.6);
    EXPECT_EQ(column_from_text("column 3", Quantity::length).choice.number, 2u);
    EXPECT_EQ(column_from_text("v", Quantity::speed).choice.factor, 1);
    EXPECT_EQ(column_from_text("yaw", Quantity::angle).problem,
              "does not say its unit; write \"yaw in deg\" or \"yaw in rad\"");
    EXPECT_EQ(column_from_text("v in kmh", Quantity::speed).problem,
              "is a speed, which can't be in \"kmh\"; did you mean \"km/h\"?");
    EXPECT_EQ(column_from_text("v times fast", Quantity::speed).problem,
              "has no number but 0 behind \"times\": \"fast\"");
    EXPECT_EQ(column_from_text("q in deg", Quantity::number).problem,
              "is a plain number and has no unit; leave \"in deg\" away");
}

TEST(CsvColumns, times_keep_every_digit) {
    EXPECT_EQ(time_from_text("46408.654976041", 0), 46408'654'976'041);
    EXPECT_EQ(time_from_text("1533226488299.000000001", -3), 1'533'226'488'299'000'000);
    EXPECT_EQ(time_from_text("1533226488299.123456", -3), 1'533'226'488'299'123'456);
    EXPECT_EQ(time_from_text("1533226488299123456", -9), 1'533'226'488'299'123'456);
    EXPECT_EQ(time_from_text("-5", -9), -5);
    EXPECT_EQ(time_from_text("-0.25", -6), -250);
    EXPECT_EQ(time_from_text("7", -6), 7000);
    EXPECT_EQ(time_from_text("1.5e3", 0), 1'500'000'000'000);
    for (const char* wrong : {"", "-", ".", "nan", "inf", "1e30", "12:30", "1 2"})
        EXPECT_FALSE(time_from_text(wrong, 0)) << wrong;
}

TEST(CsvTable, finds_header_and_separator) {
    const test::TemporaryFolder folder;
    const auto cells = [&](const std::string& text, const std::string& name) {
        Table table(folder.write("t.csv", text));
        const auto column = table.find(column_from_text(name, Quantity::length).choice);
        std::string all;
        while (column && table.next()) all += std::string(table.cell(*column)) + "|";
        return column ? all : "none";
    };
    EXPECT_EQ(cells("t,ax,az (fwd,right,down m/s2)\n1,2,3\n\n4,5,6\n", "az"), "3|6|");
    EXPECT_EQ(cells("t,ax,az (fwd,right,down m/s2)\n1,2,3\n", "az (fwd,right,down m/s2)"), "3|");
    EXPECT_EQ(cells("\xEF\xBB\xBF\"t\";\"x [m]\"\r\n1;2\r\n", "x"), "2|");
    EXPECT_EQ(cells("#timestamp [ns],w [rad s^-1]\n1,2\n# a remark\n3,4\n", "w"), "2|4|");
    EXPECT_EQ(cells("1  2 3\n 4 5\t6 \n", "column 3"), "3|6|");
    EXPECT_EQ(cells("a,b\n1,2\n", "column 3"), "none");
    EXPECT_EQ(cells("a (open,b\n1,2\n", "b"), "2|");
    EXPECT_THROW(cells("", "a"), std::runtime_error);
    EXPECT_THROW(cells("# only\n\n", "a"), std::runtime_error);
}

TEST_F(CsvImport, all_that_is_wrong_with_a_map_is_said_with_its_line) {
    folder.write("w.csv", "t,left,right\n1,1,1\n");
    EXPECT_EQ(problems("[wheels]\nkind = wheel\n[gps]\nfile = x.csv\n"),
              "map.ini:2: [wheels] kind can't be \"wheel\"; did you mean \"wheels\"?\n"
              "map.ini:3: [gps] kind is missing; it is one of odometry, steering, wheels, imu, gnss, "
              "landmarks and reference");
    EXPECT_EQ(problems("[wheels]\nkind = wheels\nfile = w.csv\ntime = t in h\nleft = left\nrigth = right\n"),
              "map.ini:4: [wheels] time is a time, which can't be in \"h\"; its units are s, ms, us and ns\n"
              "map.ini:6: [wheels] rigth is not a key of this section; did you mean \"right\"?");
    EXPECT_EQ(problems("[wheels]\nkind = wheels\nfile = w.csv\ntime = t\nleft = left\n"),
              "map.ini:1: [wheels] right is missing; name the column that holds it\n"
              "map.ini:1: [wheels] track_width_m is missing; give the distance of the wheels");
    const std::string good =
        "[wheels]\nkind = wheels\nfile = w.csv\ntime = t\ntrack_width_m = 1.5\nright = right\n";
    EXPECT_EQ(problems(good + "left = lefft in km/h\n"),
              "map.ini:7: [wheels] left names the column \"lefft\", which w.csv does not have; did you mean "
              "\"left\"?");
    EXPECT_EQ(problems(good + "left = column 4\n"), "map.ini:7: [wheels] left is column 4, and w.csv has 3");
    EXPECT_EQ(problems("[wheels]\nkind = wheels\nfile = v.csv\ntime = t\ntrack_width_m = 1\nleft = "
                       "left\nright = right\n"),
              "map.ini:3: [wheels] file names v.csv, which is neither an input nor in one; did you mean "
              "\"w.csv\"?");
    EXPECT_EQ(problems("[clock]\nutc_from = gps\n" + good + "left = left\n"),
              "map.ini:2: [clock] utc_from names no GNSS section with a column utc: \"gps\"; there is none");
    EXPECT_EQ(
        problems("[gps]\nkind = gnss\nfile = w.csv\ntime = t\neast = left\nheight = right\naltitude = right\n"
                 "speed = left\n"),
        "map.ini:1: [gps] north is missing: east and north go together\n"
        "map.ini:1: [gps] origin_latitude_deg is missing; say where east and north begin\n"
        "map.ini:1: [gps] course is missing: speed and course go together\n"
        "map.ini:7: [gps] altitude says the same as height; give one of them\n"
        "map.ini:7: [gps] altitude goes with latitude and longitude; with east and north give height, above "
        "the "
        "origin");
    folder.write("w.csv", "t,left,right\n1,x,1\n");
    EXPECT_EQ(problems(good + "left = left\n"),
              "no line of w.csv gives all that [wheels] in map.ini asks for");
    EXPECT_EQ(problems(""), "map.ini:1: there is no section of a sensor; write one, as in datasets/columns");
}

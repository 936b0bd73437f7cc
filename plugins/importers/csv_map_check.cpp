// What a section of a column map lacks, or has too much of.
#include <cmath>

#include "config/did_you_mean.h"
#include "importers/csv_map.h"

namespace loopline::csv {
namespace {

class SectionCheck {
 public:
    SectionCheck(ColumnMap& map, const Section& section, std::vector<Problem>& problems)
        : map_(map), s_(section), problems_(problems) {}

    void check() {
        if (s_.file.empty()) report("file", "is missing; name the table that holds " + s_.name);
        need("time");
        switch (s_.kind) {
            case Kind::odometry:
                need("x"), need("y"), orientation({"yaw"});
                together({"speed", "turn_rate"});
                if (s_.has("speed_left") && !s_.has("speed"))
                    report("speed_left", "needs speed and turn_rate beside it");
                break;
            case Kind::steering:
                need("speed"), need("steering");
                if (s_.car.wheel_base_m <= 0)
                    report("wheel_base_m", "is missing; give the distance of the axles");
                break;
            case Kind::wheels:
                need("left"), need("right");
                if (s_.track_width_m <= 0)
                    report("track_width_m", "is missing; give the distance of the wheels");
                break;
            case Kind::imu:
                check_imu();
                break;
            case Kind::gnss:
                check_gnss();
                break;
            case Kind::landmarks:
                need("range"), need("bearing");
                break;
            case Kind::reference:
                check_reference();
                break;
        }
    }

 private:
    void report(const std::string& key, const std::string& clause) {
        problems_.emplace_back(map_.origin(s_, key), "[" + s_.name + "] " + key + " " + clause);
    }
    void need(const std::string& key) {
        if (!s_.has(key)) report(key, "is missing; name the column that holds it");
    }
    void together(const std::vector<std::string>& keys) {
        if (!s_.has_any(keys) || s_.has_all(keys)) return;
        for (const auto& key : keys)
            if (!s_.has(key)) report(key, "is missing: " + listing(keys) + " go together");
    }
    void either(const std::string& a, const std::string& b) {
        if (s_.has(a) && s_.has(b)) report(b, "says the same as " + a + "; give one of them");
    }
    void orientation(const std::vector<std::string>& angles) {
        together({"qw", "qx", "qy", "qz"});
        const bool angle = s_.has_any(angles), quaternion = s_.has("qw");
        if (!angle && !quaternion)
            report(angles[0], "is missing; name its column, or those of qw, qx, qy and qz");
        if (angle && quaternion) report(angles[0], "says the same as the quaternion; give one of them");
    }
    /// One of several groups of columns, whole.
    void one_of(const std::vector<std::vector<std::string>>& groups) {
        std::size_t begun = 0;
        std::string all;
        for (const auto& group : groups) {
            begun += s_.has_any(group);
            together(group);
            all += (all.empty() ? "" : ", or ") + listing(group);
        }
        if (begun == 0) report(groups[0][0], "is missing; name the columns of " + all);
        if (begun > 1) report(groups[0][0], "is one place too many: give only the columns of " + all);
    }

    void check_imu() {
        for (const char* key : {"turn_rate_x", "turn_rate_y", "turn_rate_z", "acceleration_x",
                                "acceleration_y", "acceleration_z"})
            need(key);
        together({"qw", "qx", "qy", "qz"});
        if (s_.has("acceleration_time") && s_.acceleration_file.empty())
            report("acceleration_time", "is of use only with acceleration_file");
    }

    void check_gnss() {
        one_of({{"latitude", "longitude"}, {"east", "north"}});
        if (s_.has("east") && !s_.has_origin())
            report("origin_latitude_deg", "is missing; say where east and north begin");
        if (s_.has("latitude") && s_.has_origin())
            report("origin_latitude_deg", "is only for east and north");
        check_origin();
        either("height", "altitude");
        if (s_.has("east") && s_.has("altitude"))
            report("altitude",
                   "goes with latitude and longitude; with east and north give height, above the origin");
        together({"speed", "course"});
        together({"sigma_east", "sigma_north", "sigma_up"});
        together({"variance_east", "variance_north", "variance_up"});
        either("sigma_east", "variance_east");
        if ((s_.has("sigma_up") || s_.has("variance_up")) && !s_.has("height") && !s_.has("altitude"))
            report(s_.has("sigma_up") ? "sigma_up" : "variance_up",
                   "needs a height or an altitude beside it");
    }

    void check_reference() {
        one_of({{"ecef_x", "ecef_y", "ecef_z"}, {"latitude", "longitude", "height"}, {"x", "y"}});
        orientation({"yaw", "heading"});
        either("yaw", "heading");
        if (s_.has("ecef_x") && !s_.has("qw") && s_.has_any({"yaw", "heading"}))
            report(s_.has("yaw") ? "yaw" : "heading",
                   "can't go with an Earth-centred place; give qw, qx, qy and qz");
        if (!s_.has("x") && s_.has_origin()) report("origin_latitude_deg", "is only for x and y");
        check_origin();
    }

    void check_origin() {
        const bool latitude = s_.has_origin(), longitude = s_.origin_longitude_deg != Section::no_angle_deg;
        if (latitude != longitude)
            report("origin_longitude_deg", "and origin_latitude_deg go together");
        else if (latitude && std::abs(s_.origin_latitude_deg) > 90)
            report("origin_latitude_deg",
                   "is " + number_text(s_.origin_latitude_deg) + ", and there are 90 degrees of latitude");
        else if (longitude && std::abs(s_.origin_longitude_deg) > 180)
            report("origin_longitude_deg",
                   "is " + number_text(s_.origin_longitude_deg) + ", and there are 180 degrees of longitude");
    }

    ColumnMap& map_;
    const Section& s_;
    std::vector<Problem>& problems_;
};

}  // namespace

void check_section(ColumnMap& map, const Section& section, std::vector<Problem>& problems) {
    SectionCheck(map, section, problems).check();
}

}  // namespace loopline::csv

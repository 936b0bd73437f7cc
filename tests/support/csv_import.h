/// Tables written by a test, and what a column map makes of them.
#pragma once

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "api/pose3.h"
#include "api/stamp.h"
#include "gnss/gps_observation.h"
#include "importers/csv_importer.h"
#include "support/run_program.h"

namespace loopline::test {

/// All that an importer wrote.
struct Imported : RawlogSink {
    void write(const mrpt::serialization::CSerializable& object) override {
        observations.emplace_back(dynamic_cast<mrpt::obs::CObservation*>(object.clone()));
    }
    void true_pose(StampNs stamp_ns, const Pose3& T_map_base) override {
        truth.emplace_back(stamp_ns, T_map_base);
    }
    void true_frame(const EarthFrame& where) override { frame = where; }
    void warn(const std::string& sentence) override { warnings += sentence + "\n"; }

    template <class Observation>
    std::shared_ptr<Observation> at(std::size_t i) const {
        return std::dynamic_pointer_cast<Observation>(observations.at(i));
    }
    gnss::GnssFix fix(std::size_t i) const {
        const auto gps = at<mrpt::obs::CObservationGPS>(i);
        return gnss::fix_from_mrpt(*gps, *stamp_from_mrpt(gps->timestamp)).value();
    }
    StampNs stamp_ns(std::size_t i) const { return *stamp_from_mrpt(observations.at(i)->timestamp); }

    std::vector<std::shared_ptr<mrpt::obs::CObservation>> observations;
    std::vector<std::pair<StampNs, Pose3>> truth;
    std::optional<EarthFrame> frame;
    std::string warnings, summary;
};

/// A folder for the tables, in which a column map is read beside them.
class CsvImport : public ::testing::Test {
 protected:
    Imported import(const std::string& map) {
        CsvImporter importer;
        const auto table = importer.parameters();
        EXPECT_FALSE(table.find("columns")->parse(folder.write("map.ini", map)));
        Imported imported;
        imported.summary = importer.import({folder.path().string()}, imported);
        return imported;
    }
    /// The sentences, of "map.ini:LINE: ..." without the folder.
    std::string problems(const std::string& map) {
        try {
            import(map);
        } catch (const std::runtime_error& e) {
            std::string text = e.what();
            const std::string path = folder.path().string() + "/";
            for (auto at = text.find(path); at != std::string::npos; at = text.find(path))
                text.erase(at, path.size());
            return text;
        }
        return "none";
    }
    TemporaryFolder folder;
};

}  // namespace loopline::test

#include "lines/line_extraction.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>

#include "api/observation_class.h"
#include "lines/observation_lines.h"

namespace loopline {

IMPLEMENTS_MRPT_OBJECT(LineExtraction, Module, loopline)

ModuleInfo LineExtraction::info() const {
    return {"lines",
            "Extracts the straight walls of every planar laser scan, each with its covariance.",
            {"CObservation2DRangeScan"},
            {},
            {"CObservationLines"}};
}

ParameterTable LineExtraction::parameters() {
    using lines::Method;
    auto& e = extraction_;
    ParameterTable table("lines", info().sentence);
    table
        .choice("method", e.method,
                {{"angle_threshold", Method::angle_threshold},
                 {"split_and_merge", Method::split_and_merge},
                 {"incremental", Method::incremental}},
                "How a run of beams is split into straight pieces.")
        .list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .text("label", label_,
              "Sensor label of the published lines; that of the laser is appended if it has one.")
        .real("sigma_range_m", e.sigma_range_m, {0, 10},
              "Standard deviation of a range; 0 takes what each scan states, or 0.01 if it states none.")
        .angle("sigma_bearing_deg", e.sigma_bearing_rad, {0, 5}, "Standard deviation of a beam's direction.")
        .real("sigma_wall_m", e.sigma_wall_m, {0, 1},
              "Unevenness of walls: standard deviation normal to them.")
        .real("max_gap_m", e.max_gap_m, {0.01, 100},
              "Neighbouring returns further apart than this are on different walls, unless they lie on one "
              "seen at a "
              "grazing angle.")
        .angle("max_incidence_deg", e.max_incidence_rad, {0, 89},
               "Grazing angle up to which the distance between returns on one wall is allowed to grow.")
        .angle("angle_threshold_deg", e.angle_threshold_rad, {1, 80},
               "A turn between neighbouring chords sharper than this is a corner; touching lines that turn "
               "by less "
               "may be chords of a round wall and are checked for it.")
        .integer("min_beams", e.min_beams, {3, 1000}, "A line needs this many returns on it.")
        .real("min_length_m", e.min_length_m, {0, 100}, "A line must be this long.")
        .real("max_bow", e.max_bow, {0, 0.1},
              "A wall may bow by this part of its length and still be a line.")
        .angle("max_sigma_alpha_deg", e.max_sigma_alpha_rad, {0.01, 45},
               "A line whose direction is known worse than this is dropped.")
        .real("max_merge_gap_m", e.max_merge_gap_m, {0, 100},
              "Collinear lines are merged across gaps up to this.");
    return table;
}

void LineExtraction::start(const RunContext&) {
    extractor_ = lines::make_line_extractor(extraction_);
    scans_ = unusable_scans_ = 0;
}

bool LineExtraction::wanted(const std::string& sensor_label) const {
    return sensors_.empty() || std::find(sensors_.begin(), sensors_.end(), sensor_label) != sensors_.end();
}

void LineExtraction::process(const StreamItem& item, Publisher& publisher) {
    if (!wanted(item.observation->sensorLabel)) return;
    const auto scan = as<const mrpt::obs::CObservation2DRangeScan>(item.observation);
    if (!scan) return;
    if (!is_usable(*scan)) {
        ++unusable_scans_;
        return;
    }
    const auto found = pool_.take();
    found->timestamp = scan->timestamp;
    if (found->scan_label != scan->sensorLabel || found->sensorLabel.empty())
        label(*found, scan->sensorLabel);
    found->sensor_pose = scan->sensorPose;
    found->scan_beams = scan->getScanSize();
    found->set_source(*this, scan);
    ++scans_;
    publisher.publish(found);
}

void LineExtraction::label(CObservationLines& lines, const std::string& scan_label) const {
    lines.scan_label = scan_label;
    lines.sensorLabel = label_;
    if (!scan_label.empty()) lines.sensorLabel.append("_").append(scan_label);
}

void LineExtraction::extract(const mrpt::obs::CObservation2DRangeScan& scan, lines::LineSegments& segments) {
    to_planar_scan(scan, scan_);
    extractor_->extract(scan_, segments);
}

void LineExtraction::finish(Results& results) {
    results.metrics["lines_scans"] = scans_;
    results.metrics["lines_unusable_scans"] = unusable_scans_;
}

void LineExtraction::save_state(mrpt::serialization::CArchive& out) const {
    out << scans_ << unusable_scans_;
}

void LineExtraction::load_state(mrpt::serialization::CArchive& in) {
    in >> scans_ >> unusable_scans_;
}

}  // namespace loopline

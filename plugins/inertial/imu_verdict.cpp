#include "inertial/imu_verdict.h"

#include <cmath>

#include "inertial/words.h"

namespace loopline::inertial {
namespace {

using Sentences = std::vector<std::string>;

constexpr double usual_gravity_mps2 = 9.80665;

bool within(double value, double least, double most) {
    return value >= least && value <= most;
}

std::string since(StampNs log_start_ns, StampNs stamp_ns) {
    return decimals(seconds_between(log_start_ns, stamp_ns), 3) + " s";
}

void append(Sentences& to, const Sentences& more) {
    to.insert(to.end(), more.begin(), more.end());
}

/// Rotations by the gyro for one of the odometry. Noise in either pulls a slope of regression off to its own
/// side; this is the geometric mean of both ways to fit it.
double turning_scale(const Agreement& agreement) {
    return agreement.peak.slope.norm() / std::abs(agreement.correlation);
}

/// Readings in deg/s that should be in rad/s: a factor of 57.3, known to the third that odometry may be off
/// by.
bool in_degrees(const Agreement& agreement) {
    return agrees(agreement) && within(turning_scale(agreement), 40, 80);
}

std::string scale_complaint(double scale) {
    const std::string how = "turns " + digits(scale) + " times as much as the odometry: ";
    if (within(scale, 40, 80))
        return how + "its rates are in deg/s; divide them by 57.2958 when the log is recorded or imported";
    if (within(scale, 1 / 80.0, 1 / 40.0))
        return how +
               "its rates were turned from degrees to radians twice; multiply them by 57.2958 when the log "
               "is recorded or imported";
    return how +
           "the gyro's scale or the odometry's track width is wrong, or the wheels slip; compare both with a "
           "turn of known angle";
}

/// So many standard errors, known from the scatter of n values, are passed by chance as rarely as three of a
/// normal variable: Student's quantile, within a tenth from n = 4 on.
double three_sigma(int n) {
    const double freedom = n - 1;
    return 3 * (1 + 2.7 / freedom + 8 / (freedom * freedom));
}

/// Empty if there is none worth a sentence.
std::string offset_complaint(const Agreement& agreement) {
    constexpr double worth_a_look_s = 0.01, known_well_s = 0.02;
    if (!agreement.gyro_later_s || agreement.gyro_later_sigma_s > known_well_s) return {};
    const double later_s = *agreement.gyro_later_s, sigma_s = agreement.gyro_later_sigma_s;
    if (std::abs(later_s) < std::max(worth_a_look_s, three_sigma(agreement.stretches) * sigma_s)) return {};
    return "shows turns " + decimals(std::abs(later_s), 3) + " +- " + decimals(sigma_s, 3) + " s " +
           (later_s > 0 ? "after" : "before") +
           " the odometry does: the stamps of one of the two are shifted by that; correct it when the log is "
           "recorded or imported";
}

std::string bias_complaint(const Agreement& agreement) {
    constexpr double large_radps = 0.02;
    const Eigen::Vector3d bias_radps =
        agreement.peak.offset_radps / (in_degrees(agreement) ? turning_scale(agreement) : 1);
    if (bias_radps.cwiseAbs().maxCoeff() < large_radps) return {};
    return "reads " + decimals(bias_radps, 3) +
           " rad/s where the odometry does not turn: a large gyro bias; begin the log with a standstill of a "
           "few seconds, from which it is taken";
}

}  // namespace

bool turned_enough(const Agreement& agreement) {
    constexpr double least_s = 10, least_turning_radps = 0.02;
    return agreement.compared_s >= least_s && agreement.odometry_rms_radps >= least_turning_radps;
}

bool agrees(const Agreement& agreement) {
    constexpr double least_correlation = 0.7;
    return turned_enough(agreement) && std::abs(agreement.correlation) >= least_correlation;
}

Sentences stamp_complaints(const ImuCheck& check, StampNs log_start_ns) {
    constexpr double gap_in_steps = 5, least_rate_hz = 50;
    const auto& stamps = check.stamps();
    const double step_s = stamps.median_step_s();
    Sentences sentences;
    if (check.incomplete() > 0)
        sentences.push_back("lacks one of its three rates or three accelerations in " +
                            std::to_string(check.incomplete()) + " of " +
                            std::to_string(check.incomplete() + stamps.count()) +
                            " observations, which can't be used");
    if (step_s > 1 / least_rate_hz)
        sentences.push_back("comes at " + digits(1 / step_s) +
                            " Hz, and inertial navigation wants 100 Hz or more; raise its output rate");
    if (const auto gaps = stamps.gaps(gap_in_steps); gaps > 0)
        sentences.push_back("has " + std::to_string(gaps) + " gap" + (gaps > 1 ? "s" : "") +
                            " of more than " + digits(gap_in_steps) + " of its usual steps of " +
                            decimals(step_s, 4) + " s, the longest of " +
                            decimals(stamps.longest_step_s(), 3) + " s from " +
                            since(log_start_ns, stamps.longest_step_start_ns()) +
                            " on: readings are lost; look at its driver and the link");
    if (stamps.repeated() > 0)
        sentences.push_back("has " + std::to_string(stamps.repeated()) +
                            " observations with the stamp of the one before: they are stamped in packets, or "
                            "too coarsely; take the sensor's own clock");
    if (stamps.backwards() > 0)
        sentences.push_back("goes back in time " + std::to_string(stamps.backwards()) + " times, by up to " +
                            decimals(static_cast<double>(stamps.worst_backwards_ns()) * 1e-9, 4) +
                            " s; take the sensor's own clock");
    return sentences;
}

Sentences stuck_complaints(const ImuCheck& check, StampNs log_start_ns) {
    constexpr std::uint64_t least_readings = 100;
    constexpr StampNs least_ns = 1'000'000'000;
    const char* const names[] = {"gyro x",          "gyro y",          "gyro z",
                                 "accelerometer x", "accelerometer y", "accelerometer z"};
    Sentences sentences;
    for (std::size_t i = 0; i < check.channels().size(); ++i) {
        const auto& run = check.channels()[i].longest_run();
        if (run.readings < least_readings || run.last_ns - run.first_ns < least_ns) continue;
        const std::string stuck = std::string("has its ") + names[i] + " stuck at " + digits(run.value);
        sentences.push_back(check.channels()[i].never_changed()
                                ? stuck + " all the time: it is not connected, or nobody fills it in"
                                : stuck + " for " + since(run.first_ns, run.last_ns) + " from " +
                                      since(log_start_ns, run.first_ns) + " on (" +
                                      std::to_string(run.readings) +
                                      " readings): the sensor or its driver hangs");
    }
    return sentences;
}

Sentences gravity_complaints(const ImuCheck& check) {
    constexpr double tolerance_mps2 = 0.35;
    const double mean = check.mean_specific_force_base_mps2().norm();
    if (std::abs(mean - usual_gravity_mps2) <= tolerance_mps2) return {};
    const std::string how = "feels " + digits(mean) + " where gravity is 9.8 m/s^2: ";
    if (within(mean, 0.85, 1.15))
        return {how +
                "its accelerations are in g; multiply them by 9.80665 when the log is recorded or imported"};
    if (within(mean, 850, 1150))
        return {
            how +
            "its accelerations are in mg; multiply them by 0.00980665 when the log is recorded or imported"};
    if (mean < 0.5)
        return {how + "gravity was taken out of its accelerations; record what the accelerometers read"};
    return {how + "its accelerometers are off by " +
            digits(100 * std::abs(mean / usual_gravity_mps2 - 1), 2) +
            " %; calibrate their scale and biases"};
}

Sentences turning_complaints(const ImuCheck& check, const Agreement& agreement) {
    constexpr double no_correlation = 0.4;
    constexpr std::uint64_t least_seconds = 3;
    Sentences sentences;
    if (!in_degrees(agreement) && check.absurd_seconds() >= least_seconds)
        sentences.push_back("turns by more than " + digits(ImuCheck::absurd_rate_radps) + " rad/s in " +
                            std::to_string(check.absurd_seconds()) +
                            " seconds of the log: its rates are probably in deg/s; divide them by 57.2958 "
                            "when the log is recorded or imported");
    if (turned_enough(agreement) && std::abs(agreement.correlation) < no_correlation)
        sentences.push_back(
            "does not turn with the odometry: none of its gyro's axes follows the odometry's heading "
            "(correlation " +
            decimals(agreement.correlation, 2) + " over " + decimals(agreement.compared_s, 0) +
            " s); stamps more than a second apart, or a sensor that hangs");
    if (!agrees(agreement)) return sentences;
    const double scale = turning_scale(agreement);
    if (!within(scale, 0.8, 1.25)) sentences.push_back(scale_complaint(scale));
    for (auto sentence : {bias_complaint(agreement), offset_complaint(agreement)})
        if (!sentence.empty()) sentences.push_back(sentence);
    return sentences;
}

Sentences imu_complaints(const ImuCheck& check, const std::string& label, StampNs log_start_ns) {
    constexpr std::uint64_t least_readings = 20;
    Sentences sentences = stamp_complaints(check, log_start_ns);
    if (check.stamps().count() < least_readings) return sentences;
    const Agreement agreement = check.agreement();
    append(sentences, stuck_complaints(check, log_start_ns));
    append(sentences, gravity_complaints(check));
    append(sentences, turning_complaints(check, agreement));
    append(sentences, mounting_complaints(check, agreement, label));
    return sentences;
}

}  // namespace loopline::inertial

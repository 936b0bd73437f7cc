#include "lidar/velodyne_packets.h"

#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <cmath>

#include "lidar/beam_table.h"

namespace loopline::lidar {
namespace {

using Scan = mrpt::obs::CObservationVelodyneScan;

constexpr std::uint32_t hour_us = 3'600'000'000U;  ///< where the clock of packets begins anew
constexpr int turn = 36000;                        ///< in units of a block's azimuth

/// When the returns of a packet were measured.
struct Firing {
    explicit Firing(std::size_t lasers, bool dual) {
        firings_per_block = lasers == 16 ? 2 : 1;
        firing_us = lasers == 16 ? 55.296 : lasers == 32 ? 46.08 : 48.0;
        laser_us = lasers == 16 ? 2.304 : lasers == 32 ? 1.152 : 0.0;
        blocks_together = (lasers > 32 ? 2 : 1) * (dual ? 2 : 1);
    }
    int firings_per_block = 1;
    int blocks_together = 1;  ///< that are of one moment
    double firing_us = 0, laser_us = 0;

    double moment_us() const { return firing_us * firings_per_block; }
    double packet_us() const { return moment_us() * Scan::BLOCKS_PER_PACKET / blocks_together; }
};

/// Turned a microsecond, about a block: from the blocks of one moment to those of the next.
double azimuth_per_us(const Scan::TVelodyneRawPacket& packet, int block, const Firing& firing) {
    const int first = std::min(block, Scan::BLOCKS_PER_PACKET - 1 - firing.blocks_together);
    const int turned =
        packet.blocks[first + firing.blocks_together].rotation() - packet.blocks[first].rotation();
    return ((turned + turn) % turn) / firing.moment_us();
}

/// Velodyne's manual, "XML calibration": azimuth clockwise from ahead.
SpinningPoint point_of(const mrpt::obs::VelodyneCalibration::PerLaserCalib& laser, double range_m,
                       double azimuth, double time_s) {
    const double a_rad = azimuth * (2 * M_PI / turn) - laser.azimuthCorrection * (M_PI / 180);
    const double s = std::sin(a_rad), c = std::cos(a_rad), r_m = range_m + laser.distanceCorrection;
    const double level_m =
        r_m * laser.cosVertCorrection - laser.verticalOffsetCorrection * laser.sinVertCorrection;
    return {static_cast<float>(level_m * c + laser.horizontalOffsetCorrection * s),
            static_cast<float>(-level_m * s + laser.horizontalOffsetCorrection * c),
            static_cast<float>(r_m * laser.sinVertCorrection +
                               laser.verticalOffsetCorrection * laser.cosVertCorrection),
            static_cast<float>(time_s)};
}

}  // namespace

bool VelodynePackets::read(const Scan& packets, SpinningScan& scan, std::vector<std::uint16_t>* intensity) {
    const auto& corrections = packets.calibration.laser_corrections;
    if (corrections.empty() || packets.scan_packets.empty()) return false;
    lasers_.resize(corrections.size());
    for (Laser& laser : lasers_) {
        laser.points.clear();
        laser.intensity.clear();
    }
    const auto& all = packets.scan_packets;
    const bool has_clock = all.size() < 2 || all[1].gps_timestamp() != all[0].gps_timestamp();
    for (std::size_t p = 0; p < all.size(); ++p) {
        const bool dual = all[p].laser_return_mode == Scan::RETMODE_DUAL;
        const Firing firing(corrections.size(), dual);
        const double packet_us =
            has_clock
                ? static_cast<double>((all[p].gps_timestamp() + hour_us - all[0].gps_timestamp()) % hour_us)
                : static_cast<double>(p) * firing.packet_us();
        for (int b = 0; b < Scan::BLOCKS_PER_PACKET; b += dual ? 2 : 1) {
            const auto& block = all[p].blocks[b];
            const std::size_t bank = block.header() == Scan::LOWER_BANK ? 32 : 0;
            const double per_us = azimuth_per_us(all[p], b, firing);
            for (int k = 0; k < Scan::SCANS_PER_BLOCK; ++k) {
                const auto& found = block.laser_returns[k];
                const int per_firing = Scan::SCANS_PER_BLOCK / firing.firings_per_block;
                const std::size_t laser = bank + static_cast<std::size_t>(k % per_firing);
                const double range_m = found.distance() * static_cast<double>(Scan::DISTANCE_RESOLUTION);
                if (laser >= lasers_.size() || found.distance() == 0 || range_m < packets.minRange ||
                    range_m > packets.maxRange)
                    continue;
                const double in_block_us =
                    k / per_firing * firing.firing_us + k % per_firing * firing.laser_us;
                const double time_us =
                    packet_us + b / firing.blocks_together * firing.moment_us() + in_block_us;
                lasers_[laser].points.push_back(point_of(
                    corrections[laser], range_m, block.rotation() + per_us * in_block_us, 1e-6 * time_us));
                lasers_[laser].intensity.push_back(static_cast<std::uint16_t>(found.intensity() * 257));
            }
        }
    }
    std::vector<double> elevations_deg;
    for (const auto& laser : corrections) elevations_deg.push_back(laser.verticalCorrection);
    scan.begin_s = scan.end_s = 0;
    for (const int number : from_high_to_low(elevations_deg)) {
        const Laser& laser = lasers_[static_cast<std::size_t>(number)];
        scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
        scan.points.insert(scan.points.end(), laser.points.begin(), laser.points.end());
        if (intensity != nullptr)
            intensity->insert(intensity->end(), laser.intensity.begin(), laser.intensity.end());
        if (!laser.points.empty())
            scan.end_s = std::max(scan.end_s, static_cast<double>(laser.points.back().time_s));
    }
    scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
    return true;
}

}  // namespace loopline::lidar

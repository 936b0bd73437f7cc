/// A simulated log of a lidar with 16 or 32 beams, as a Velodyne would have sent it: packets with times of
/// their own.
#pragma once

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "lidar/beam_table.h"

namespace loopline::test {

/// A block holds one column of 32 beams or two of 16, a packet twelve blocks (Velodyne, user manuals of
/// HDL-32E and VLP-16). The image's columns are clockwise and its ranges in 2 mm, as a Velodyne's.
inline mrpt::obs::CObservationVelodyneScan::Ptr packets_of(const mrpt::obs::CObservationRotatingScan& image) {
    using Scan = mrpt::obs::CObservationVelodyneScan;
    auto scan = Scan::Create();
    scan->timestamp = scan->originalReceivedTimestamp = image.timestamp;
    scan->sensorLabel = image.sensorLabel;
    scan->sensorPose = image.sensorPose;
    scan->minRange = image.minRange;
    scan->maxRange = image.maxRange;
    const int lasers = image.rowCount, firings = Scan::SCANS_PER_BLOCK / lasers;
    scan->calibration =
        mrpt::obs::VelodyneCalibration::LoadDefaultCalibration(lasers == 16 ? "VLP16" : "HDL32");
    // Which laser shines where is in the calibration, to a hundredth of a degree.
    const auto elevations_deg = lidar::table_from_text(image.lidarModel)->elevations_deg;
    std::vector<int> row_of_laser;
    for (const auto& laser : scan->calibration.laser_corrections)
        for (int row = 0; row < lasers; ++row)
            if (std::abs(elevations_deg[static_cast<std::size_t>(row)] - laser.verticalCorrection) < 0.02)
                row_of_laser.push_back(row);
    const auto part = [&image](int column) { return double(column) / (image.columnCount - 1); };
    const int columns_per_packet = firings * Scan::BLOCKS_PER_PACKET;
    for (int first = 0; first + columns_per_packet <= image.columnCount; first += columns_per_packet) {
        unsigned char bytes[Scan::PACKET_SIZE] = {};
        unsigned char* at = bytes;
        const auto put = [&at](auto value) {
            std::memcpy(at, &value, sizeof value);
            at += sizeof value;
        };
        for (int column = first; column < first + columns_per_packet; column += firings) {
            const double clockwise_deg =
                -(image.startAzimuth + image.azimuthSpan * part(column)) * 180 / M_PI;
            put(std::uint16_t(Scan::UPPER_BANK));
            put(static_cast<std::uint16_t>(std::lround(100 * (clockwise_deg + 720)) % 36000));
            for (int k = column; k < column + firings; ++k)
                for (const int row : row_of_laser) {
                    put(image.rangeImage(row, k));
                    put(std::uint8_t{100});
                }
        }
        put(static_cast<std::uint32_t>(std::lround(1e6 * image.sweepDuration * part(first))));
        put(std::uint8_t(Scan::RETMODE_STRONGEST));
        put(static_cast<std::uint8_t>(lasers == 16 ? 0x22 : 0x21));
        Scan::TVelodyneRawPacket packet;
        static_assert(sizeof packet == sizeof bytes);
        std::memcpy(static_cast<void*>(&packet), bytes, sizeof bytes);
        scan->scan_packets.push_back(packet);
    }
    return scan;
}

/// Every image of `from` as packets in `to`.
inline void write_as_packets(const std::string& from, const std::string& to) {
    mrpt::io::CFileGZInputStream in(from);
    mrpt::io::CFileGZOutputStream out(to);
    auto archive_in = mrpt::serialization::archiveFrom(in);
    auto archive_out = mrpt::serialization::archiveFrom(out);
    try {
        while (true) {
            const auto image =
                std::dynamic_pointer_cast<mrpt::obs::CObservationRotatingScan>(archive_in.ReadObject());
            if (image) archive_out << *packets_of(*image);
        }
    } catch (const mrpt::serialization::CExceptionEOF&) {
        // A gzip stream does not say so before.
    }
}

}  // namespace loopline::test

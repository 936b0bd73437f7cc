/// Points in space to be drawn, wherever they are.
#pragma once

#include <mrpt/maps/CPointsMap.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "api/stored_cloud.h"

namespace loopline {

class PointSource {
 public:
    using Use = std::function<void(const Eigen::Vector3f& p_map_m)>;
    virtual ~PointSource() = default;
    virtual std::size_t size() const = 0;
    /// Calls `use` with every `stride`-th point; some may not be finite.
    virtual void for_each(std::size_t stride, const Use& use) const = 0;
};

/// Of MRPT's map, which must outlive it.
class PointsOfMap : public PointSource {
 public:
    explicit PointsOfMap(const mrpt::maps::CPointsMap& map) : map_(map) {}
    std::size_t size() const override { return map_.size(); }
    void for_each(std::size_t stride, const Use& use) const override {
        const auto& x = map_.getPointsBufferRef_x();
        const auto& y = map_.getPointsBufferRef_y();
        const auto& z = map_.getPointsBufferRef_z();
        for (std::size_t i = 0; i < x.size(); i += stride) use({x[i], y[i], z[i]});
    }

 private:
    const mrpt::maps::CPointsMap& map_;
};

/// Of a cloud that may be on disk, which must outlive it.
class PointsOfCloud : public PointSource {
 public:
    explicit PointsOfCloud(const StoredCloud& cloud) : cloud_(cloud) {}
    std::size_t size() const override { return cloud_.points().size(); }
    void for_each(std::size_t stride, const Use& use) const override {
        std::size_t left = 0;
        cloud_.points().for_each(0, size(), [&](const CloudPoint& point) {
            if (left-- > 0) return;
            left = stride - 1;
            use(point.p_map_m().cast<float>());
        });
    }

 private:
    const StoredCloud& cloud_;
};

class PointsInMemory : public PointSource {
 public:
    explicit PointsInMemory(std::vector<Eigen::Vector3f> points_m) : points_m_(std::move(points_m)) {}
    std::size_t size() const override { return points_m_.size(); }
    void for_each(std::size_t stride, const Use& use) const override {
        for (std::size_t i = 0; i < points_m_.size(); i += stride) use(points_m_[i]);
    }

 private:
    std::vector<Eigen::Vector3f> points_m_;
};

}  // namespace loopline

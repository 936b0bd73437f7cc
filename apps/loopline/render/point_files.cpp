#include "render/point_files.h"

#include "commands/command.h"
#include "point_files/point_file.h"

namespace loopline {
namespace {

template <class Reading>
auto read_or_refuse(const Reading& reading) {
    try {
        return reading();
    } catch (const PointFileError& error) {
        throw CommandError(exit_input_data, std::string(error.what()) + ".");
    }
}

class PointsOfFile : public PointSource {
 public:
    explicit PointsOfFile(std::shared_ptr<const PointFile> file) : file_(std::move(file)) {}
    std::size_t size() const override { return file_->size(); }
    void for_each(std::size_t stride, const Use& use) const override {
        const Eigen::Vector3d origin_m = file_->grid_origin_m();
        read_or_refuse([&] {
            file_->for_each(stride, [&](const Eigen::Vector3d& p_m) { use((p_m - origin_m).cast<float>()); });
        });
    }

 private:
    std::shared_ptr<const PointFile> file_;
};

}  // namespace

std::shared_ptr<const PointSource> points_of_file(const std::filesystem::path& file) {
    return std::make_shared<PointsOfFile>(read_or_refuse([&] { return open_point_file(file); }));
}

std::vector<Eigen::Vector3f> finite_points(const PointSource& points) {
    std::vector<Eigen::Vector3f> points_m;
    points.for_each(1, [&](const Eigen::Vector3f& p) {
        if (p.allFinite()) points_m.push_back(p);
    });
    return points_m;
}

}  // namespace loopline

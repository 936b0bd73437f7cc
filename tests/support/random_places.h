/// Places all over the Earth, the same in every run.
#pragma once

#include <random>

#include "gnss/geodetic.h"

namespace loopline::test {

class RandomPlaces {
 public:
    explicit RandomPlaces(unsigned seed) : engine_(seed) {}

    double between(double from, double to) {
        return from + (to - from) * static_cast<double>(engine_()) / 4294967296.0;
    }
    gnss::Geodetic draw(double least_latitude_deg, double most_latitude_deg) {
        const double latitude = between(least_latitude_deg, most_latitude_deg);
        const double longitude = between(-180, 180);
        return {latitude, longitude, between(-100, 9000)};
    }

 private:
    std::mt19937 engine_;
};

}  // namespace loopline::test

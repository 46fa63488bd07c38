// The library's PID moves a servo and identifies it. Here the servo is a few lines of arithmetic.
#include <cmath>
#include <cstdio>

#include "servo_id.hpp"

namespace {

constexpr double TURN = 6.283185307179586; // rad
// Counts to either side, and samples until it turns.
constexpr int32_t DISTANCE = 400;
constexpr int SAMPLES = 20000, HELD = 100;

// q'' = -2 q' + 257.7 u + 20, rad.
class Plant {
public:
    int32_t count() const { return static_cast<int32_t>(std::floor(position_ / TURN * COUNTS)); }
    void advance(double command) {
        const double next = velocity_ + TIME * (B * command - 2.0 * velocity_ + 20.0);
        position_ += TIME * (velocity_ + next) / 2.0;
        velocity_ = next;
    }
    static constexpr double TIME = 1e-3, COUNTS = 10000.0, B = 257.7;

private:
    double position_ = 0.0, velocity_ = 0.0;
};

} // namespace

int main() {
    Plant plant;
    servo_id::Error error{};
    servo_id::Settings settings(Plant::TIME, Plant::COUNTS);
    settings.kp = 9.0;
    settings.kd = 0.19;
    settings.ki = 4.0;
    settings.limit = {-10.0, 10.0};
    settings.servo_range = {{0.0, 50.0}, {110.0, 1000.0}};

    servo_id::GradientLoop loop;
    if (const auto status = loop.init(settings, plant.count(), &error); !status) {
        std::printf("%s: %s\n", status.text(), error.parameter != nullptr ? error.parameter : "");
        return 1;
    }
    for (int sample = 0; sample < SAMPLES; sample++) {
        float command = 0.0F;
        const auto status = loop.process(sample / HELD % 2 != 0 ? DISTANCE : -DISTANCE, 0.0F, plant.count(), command);
        plant.advance(status ? command : 0.0);
    }
    servo_id::Estimates found{};
    loop.estimates(found);
    std::printf("a = %.2f, b = %.1f, load = %.1f\n", found.value[SERVO_ID_A], found.value[SERVO_ID_B],
                found.value[SERVO_ID_LOAD]);
    return std::abs(found.value[SERVO_ID_B] / Plant::B - 1.0) < 0.02 ? 0 : 1;
}

// The library's PID moves a servo and identifies it. Here the servo is a few lines of arithmetic.
#include <cmath>
#include <cstdio>

#include "servo_id.hpp"

namespace {

// q'' = -2 q' + 257.7 u + 20, rad.
class Plant {
public:
    int32_t count() const { return static_cast<int32_t>(std::floor(position_ / 6.283185307179586 * COUNTS)); }
    void advance(double command) {
        const double next = velocity_ + TIME * (257.7 * command - 2.0 * velocity_ + 20.0);
        position_ += TIME * (velocity_ + next) / 2.0;
        velocity_ = next;
    }
    static constexpr double TIME = 1e-3, COUNTS = 10000.0;

private:
    double position_ = 0.0, velocity_ = 0.0;
};

} // namespace

int main() {
    Plant plant;
    servo_id::Error error{};
    servo_id::Settings settings(Plant::TIME, Plant::COUNTS);
    settings.set(SERVO_ID_KP, 9.0)
        .set(SERVO_ID_KD, 0.19)
        .set(SERVO_ID_KI, 4.0)
        .set(SERVO_ID_LIMIT, -10.0, 10.0)
        .set(SERVO_ID_PLANT_BOX_A, 0.0, 50.0)
        .set(SERVO_ID_PLANT_BOX_B, 110.0, 1000.0)
        .choose_gamma(0.3, 0.05, 2000, false, &error);

    servo_id::GradientLoop loop;
    if (const auto status = loop.init(settings, plant.count(), &error); !status) {
        std::printf("%s: parameter %d\n", status.text(), static_cast<int>(error.parameter));
        return 1;
    }
    for (int sample = 0; sample < 20000; sample++) {
        float command = 0.0F;
        const auto status = loop.process(sample / 100 % 2 != 0 ? 400 : -400, 0.0F, plant.count(), command);
        plant.advance(status ? command : 0.0);
    }
    servo_id::Estimates found{};
    loop.estimates(found);
    std::printf("a = %.2f, b = %.1f, load = %.1f\n", found.value[SERVO_ID_A], found.value[SERVO_ID_B],
                found.value[SERVO_ID_LOAD]);
    return std::abs(found.value[SERVO_ID_B] / 257.7 - 1.0) < 0.02 ? 0 : 1;
}

// Runs a sketch for ten seconds of a motor's time: 20 us a loop, and every other second one that is late.
#include <SimpleFOC.h>

void setup();
void loop();

SerialPort Serial;

namespace {

// Of the motor: a (1/s), b (rad/s^2 per V), Coulomb friction (rad/s^2).
constexpr double A = 8.0, B = 90.0, COULOMB = 30.0;
// The sensor is mounted against the motor.
constexpr double COUNTS = 4096.0, TURN = 6.283185307179586;

double now, position = 3.0, velocity, voltage;

void run(double until) {
    while (now < until) {
        const double step = 1e-5;
        const double pushed = velocity + step * (B * voltage - A * velocity);
        const double rubbed = step * COULOMB;
        velocity = pushed > rubbed ? pushed - rubbed : pushed < -rubbed ? pushed + rubbed : 0.0;
        position += step * velocity;
        now += step;
    }
}

} // namespace

uint32_t micros() { return static_cast<uint32_t>(std::llround(now * 1e6)) + 4294000000u; }
uint32_t millis() { return static_cast<uint32_t>(now * 1e3); }

float MagneticSensorI2C::getMechanicalAngle() {
    const double counts = std::floor(-position / TURN * COUNTS);
    return static_cast<float>((counts - COUNTS * std::floor(counts / COUNTS)) / COUNTS * TURN);
}

// As SimpleFOC's newer versions do, and not in move.
void BLDCMotor::loopFOC() {
    voltage.q = current_sp;
    ::voltage = voltage.q;
}

void BLDCMotor::move(float target) {
    const double wanted = 15.0 * (target + 3.0 - position);
    const double asked = 0.4 * (wanted - velocity);
    current_sp = static_cast<float>(asked > 6.0 ? 6.0 : asked < -6.0 ? -6.0 : asked);
}

int main() {
    setup();
    for (long sample = 0; now < 10.0; sample++) {
        loop();
        run(now + (sample % 100000 == 99999 ? 5e-3 : 2e-5));
    }
}

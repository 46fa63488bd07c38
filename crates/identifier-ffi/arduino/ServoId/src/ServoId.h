// Identifies a motor that SimpleFOC runs: call ServoIdMotor::move instead of motor.move.
#ifndef SERVO_ID_ARDUINO_H
#define SERVO_ID_ARDUINO_H

#include <Arduino.h>
#include <SimpleFOC.h>
#include <math.h>

#include "servo_id.hpp"

// The identifier of one motor. The command is the voltage, or the current if SimpleFOC controls the current.
class ServoIdMotor {
public:
    // The time from move to move (s), and the counts of the sensor's revolution.
    ServoIdMotor(float sample_time, int32_t counts)
        : settings_(sample_time, counts), period_(lroundf(1e6f * sample_time)), counts_(counts) {}

    // Settings before begin, as of servo_id.h.
    servo_id::Settings &settings() { return settings_; }

    // After motor.initFOC.
    servo_id::Status begin() {
        joined_ = false;
        return identifier_.init(settings_);
    }

    // Instead of motor.move(target), as often as motor.loopFOC(): the motor moves once in each sample time.
    template <class Motor> servo_id::Status move(Motor &motor, float target) {
        const uint32_t now = micros();
        if (joined_ && now - last_time_ < period_) {
            return identifier_.work(BLOCKS);
        }
        const int32_t count = lroundf(motor.sensor->getMechanicalAngle() / _2PI * counts_);
        int32_t moved = static_cast<int32_t>(motor.sensor_direction) * (count - last_count_);
        moved -= counts_ * lroundf(static_cast<float>(moved) / counts_);
        const uint32_t late = now - last_time_;
        const bool in_time = joined_ && late < 2 * period_;
        last_count_ = count;
        last_time_ = in_time ? last_time_ + period_ : now;
        // The command that acted since the last sample: some versions of SimpleFOC output it in move, others in loopFOC.
        const bool is_voltage = motor.torque_controller == TorqueControlType::voltage;
        const float acted = is_voltage ? motor.voltage.q : motor.current_sp;
        motor.move(target);
        if (in_time) {
            const int32_t before = last_moved_;
            last_moved_ = moved;
            return identifier_.sample(before, acted);
        }
        // The first sample, or a gap: the speed across it is a guess.
        last_moved_ = joined_ ? moved / static_cast<int32_t>(late / period_) : 0;
        joined_ = true;
        return identifier_.resume(last_moved_);
    }

    // SERVO_ID_NO_FIT before there are any.
    servo_id::Status estimates(servo_id::Estimates &estimates) const { return identifier_.estimates(estimates); }

    // a, b, Coulomb friction and load, each with twice its standard error, on a line.
    template <class Output> void print(Output &output) const {
        servo_id::Estimates found;
        const servo_id::Status status = estimates(found);
        if (status.number() != SERVO_ID_OK) {
            output.println(status.text());
            return;
        }
        static const char *const NAMES[] = {"a", "b", "coulomb", "load"};
        for (int place = 0; place < 4; place++) {
            output.print(NAMES[place]);
            output.print(" = ");
            output.print(found.value[place], 3);
            output.print(" +- ");
            output.print(2 * found.std_error[place], 3);
            output.print(place < 3 ? "  " : "\r\n");
        }
    }

private:
    // Blocks of the first fit between two samples.
    static constexpr uint32_t BLOCKS = 4;

    servo_id::Settings settings_;
    servo_id::GaussNewton identifier_;
    uint32_t period_;
    int32_t counts_;
    uint32_t last_time_ = 0;
    int32_t last_count_ = 0;
    int32_t last_moved_ = 0;
    bool joined_ = false;
};

#endif

// The members of SimpleFOC 2.3 that the library and its example use, around a motor of a few lines.
#pragma once

#include "Arduino.h"

#define _2PI 6.28318530718f

enum class TorqueControlType { voltage, dc_current, foc_current };
enum class MotionControlType { torque, velocity, angle };
enum Direction : int8_t { CW = 1, CCW = -1, UNKNOWN = 0 };
struct DQVoltage_s {
    float d, q;
};
struct I2CConfig {};
inline I2CConfig AS5600_I2C;

class Sensor {
public:
    virtual ~Sensor() = default;
    virtual float getMechanicalAngle() = 0;
};

class MagneticSensorI2C : public Sensor {
public:
    explicit MagneticSensorI2C(I2CConfig) {}
    void init() {}
    float getMechanicalAngle() override;
};

struct BLDCDriver3PWM {
    BLDCDriver3PWM(int, int, int, int) {}
    void init() {}
    float voltage_power_supply = 0.0f;
};

class BLDCMotor {
public:
    explicit BLDCMotor(int) {}
    void linkSensor(Sensor *own) { sensor = own; }
    void linkDriver(BLDCDriver3PWM *) {}
    void init() {}
    void initFOC() {}
    void loopFOC();
    void move(float target);

    Sensor *sensor = nullptr;
    Direction sensor_direction = CCW;
    TorqueControlType torque_controller = TorqueControlType::voltage;
    MotionControlType controller = MotionControlType::torque;
    DQVoltage_s voltage{};
    float current_sp = 0.0f;
};

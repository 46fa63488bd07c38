// A motor in angle control that identifies itself while it moves to and fro.
#include <ServoId.h>
#include <SimpleFOC.h>

BLDCMotor motor = BLDCMotor(7);
BLDCDriver3PWM driver = BLDCDriver3PWM(9, 5, 6, 8);
MagneticSensorI2C sensor = MagneticSensorI2C(AS5600_I2C);

// A sample a millisecond, and 4096 counts of the AS5600.
ServoIdMotor identifier(1e-3f, 4096);

void setup() {
    Serial.begin(115200);
    sensor.init();
    motor.linkSensor(&sensor);
    driver.voltage_power_supply = 12;
    driver.init();
    motor.linkDriver(&driver);
    motor.controller = MotionControlType::angle;
    motor.init();
    motor.initFOC();
    if (!identifier.begin()) {
        Serial.println("the settings are not allowed");
    }
}

void loop() {
    static uint32_t printed = 0;
    motor.loopFOC();
    // To and fro every 300 ms: instead of motor.move(target).
    identifier.move(motor, millis() / 300 % 2 ? 1.0f : -1.0f);
    if (millis() - printed > 1000) {
        printed = millis();
        identifier.print(Serial);
    }
}

// The least of Arduino that a sketch needs, on a PC whose time is that of a motor.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>

uint32_t micros();
uint32_t millis();

struct SerialPort {
    void begin(unsigned long) {}
    void print(const char *text) { std::printf("%s", text); }
    void print(double value, int digits) { std::printf("%.*f", digits, value); }
    void println(const char *text) { std::printf("%s\r\n", text); }
};
extern SerialPort Serial;

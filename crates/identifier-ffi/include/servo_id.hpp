// servo_id.hpp: servo_id.h for C++17, without exceptions, heap and globals.
#ifndef SERVO_ID_HPP
#define SERVO_ID_HPP

#include "servo_id.h"

namespace servo_id {

using Error = servo_id_error;
using Estimates = servo_id_estimates;
using Servo = servo_id_servo;
using Tuning = servo_id_tuning;
using Verdict = servo_id_verdict;

// The status of a call: a number of servo_id.h.
class Status {
public:
    constexpr Status(int32_t number) : number_(number) {}
    // True without an error.
    constexpr explicit operator bool() const { return number_ >= 0; }
    constexpr int32_t number() const { return number_; }
    const char *text() const {
        const char *text = "";
        servo_id_status_text(number_, &text);
        return text;
    }

private:
    int32_t number_;
};

// Settings: the fields of servo_id_settings, zero where nothing is stated.
struct Settings : servo_id_settings {
    Settings(double sample_time, double counts_per_revolution) : servo_id_settings{} {
        this->sample_time = sample_time;
        this->counts_per_revolution = counts_per_revolution;
    }
    // See servo_id_settings_choose_gamma.
    Status choose_gamma(double amplitude, double hold, uint32_t samples, bool coulomb, Error *error = nullptr) {
        return servo_id_settings_choose_gamma(this, amplitude, hold, samples, coulomb ? 1 : 0, error);
    }
};

namespace detail {

// The functions of an identifier; N is the number type of a command.
template <class T, class N, int32_t (*Init)(T *, uint32_t, const servo_id_settings *, servo_id_error *),
          int32_t (*Sample)(T *, int32_t, N), int32_t (*Resume)(T *, int32_t),
          int32_t (*Get)(const T *, servo_id_estimates *),
          int32_t (*Work)(T *, uint32_t), int32_t (*FromConstants)(T *, uint32_t, const uint32_t *, uint32_t),
          int32_t (*Machine)(const T *, N *)>
class Listening {
public:
    Status init(const servo_id_settings &settings, Error *error = nullptr) {
        return Init(&own_, sizeof own_, &settings, error);
    }
    // From the array that `servo-id export --firmware c` writes.
    template <uint32_t Words> Status init(const uint32_t (&constants)[Words]) {
        return FromConstants(&own_, sizeof own_, constants, Words);
    }
    Status sample(int32_t moved, N command) { return Sample(&own_, moved, command); }
    Status resume(int32_t moved) { return Resume(&own_, moved); }
    Status estimates(Estimates &estimates) const { return Get(&own_, &estimates); }
    Status work(uint32_t blocks) { return Work(&own_, blocks); }
    Status machine_estimates(N (&machine)[4]) const { return Machine(&own_, machine); }
    T *get() { return &own_; }
    const T *get() const { return &own_; }

private:
    T own_{};
};

// The functions of a loop; N is the number type of a command and an offset.
template <class T, class N, int32_t (*Init)(T *, uint32_t, const servo_id_settings *, int32_t, servo_id_error *),
          int32_t (*Process)(T *, int32_t, N, int32_t, N *), int32_t (*Control)(T *, int32_t, N, int32_t, N *),
          int32_t (*Learn)(T *, N), int32_t (*Get)(const T *, servo_id_estimates *),
          int32_t (*Work)(T *, uint32_t),
          int32_t (*FromConstants)(T *, uint32_t, const uint32_t *, uint32_t, int32_t), int32_t (*Machine)(const T *, N *)>
class Closed {
public:
    Status init(const servo_id_settings &settings, int32_t count, Error *error = nullptr) {
        return Init(&own_, sizeof own_, &settings, count, error);
    }
    // From the array that `servo-id export --firmware c` writes.
    template <uint32_t Words> Status init(const uint32_t (&constants)[Words], int32_t count) {
        return FromConstants(&own_, sizeof own_, constants, Words, count);
    }
    Status process(int32_t setpoint, N offset, int32_t count, N &command) {
        return Process(&own_, setpoint, offset, count, &command);
    }
    Status control(int32_t setpoint, N offset, int32_t count, N &command) {
        return Control(&own_, setpoint, offset, count, &command);
    }
    Status learn(N acted) { return Learn(&own_, acted); }
    Status estimates(Estimates &estimates) const { return Get(&own_, &estimates); }
    Status work(uint32_t blocks) { return Work(&own_, blocks); }
    Status machine_estimates(N (&machine)[4]) const { return Machine(&own_, machine); }
    T *get() { return &own_; }
    const T *get() const { return &own_; }

private:
    T own_{};
};

} // namespace detail

#define SERVO_ID_LISTENING(NAME, NUMBER)                                                                               \
    detail::Listening<servo_id_##NAME, NUMBER, servo_id_##NAME##_init, servo_id_##NAME##_sample,                       \
                      servo_id_##NAME##_resume, servo_id_##NAME##_estimates, servo_id_##NAME##_work,                   \
                      servo_id_##NAME##_init_from_constants, servo_id_##NAME##_machine_estimates>
#define SERVO_ID_CLOSED(NAME, NUMBER)                                                                                  \
    detail::Closed<servo_id_##NAME, NUMBER, servo_id_##NAME##_init, servo_id_##NAME##_process,                         \
                   servo_id_##NAME##_control, servo_id_##NAME##_learn, servo_id_##NAME##_estimates,                    \
                   servo_id_##NAME##_work, servo_id_##NAME##_init_from_constants,                                      \
                   servo_id_##NAME##_machine_estimates>
#define SERVO_ID_LEARNS(NAME)                                                                                          \
    Status learn(float increment, float command) { return servo_id_##NAME##_learn(get(), increment, command); }
#define SERVO_ID_SCALES(NAME)                                                                                          \
    Status scale(double &scale) const { return servo_id_##NAME##_scale(get(), &scale); }

class Gradient : public SERVO_ID_LISTENING(gradient, float) {
public:
    SERVO_ID_LEARNS(gradient)
};
class GradientCoulomb : public SERVO_ID_LISTENING(gradient_coulomb, float) {
public:
    SERVO_ID_LEARNS(gradient_coulomb)
};
class GaussNewton : public SERVO_ID_LISTENING(gauss_newton, float) {
public:
    SERVO_ID_LEARNS(gauss_newton)
};
class Fixed : public SERVO_ID_LISTENING(fixed, int32_t) {
public:
    SERVO_ID_SCALES(fixed)
};
class FixedCoulomb : public SERVO_ID_LISTENING(fixed_coulomb, int32_t) {
public:
    SERVO_ID_SCALES(fixed_coulomb)
};
class GradientLoop : public SERVO_ID_CLOSED(gradient_loop, float) {};
class GradientCoulombLoop : public SERVO_ID_CLOSED(gradient_coulomb_loop, float) {};
class GaussNewtonLoop : public SERVO_ID_CLOSED(gauss_newton_loop, float) {};
class FixedLoop : public SERVO_ID_CLOSED(fixed_loop, int32_t) {
public:
    SERVO_ID_SCALES(fixed_loop)
};
class FixedCoulombLoop : public SERVO_ID_CLOSED(fixed_coulomb_loop, int32_t) {
public:
    SERVO_ID_SCALES(fixed_coulomb_loop)
};

#undef SERVO_ID_LISTENING
#undef SERVO_ID_CLOSED
#undef SERVO_ID_LEARNS
#undef SERVO_ID_SCALES

// The verdict in short: see servo_id_judge.
inline Status judge(const Estimates &estimates, double command, double speed, Verdict &verdict) {
    return servo_id_judge(&estimates, command, speed, &verdict);
}

// The servo of estimates: see servo_id_servo_from_estimates.
inline Status servo_from(const Estimates &estimates, double delay, double unexplained, Servo &servo) {
    return servo_id_servo_from_estimates(&estimates, delay, unexplained, &servo);
}

// A search for gains.
class Tuner {
public:
    Status init(const servo_id_settings &settings, const Servo &servo, Error *error = nullptr) {
        return servo_id_tuner_init(&own_, sizeof own_, &settings, &servo, error);
    }
    // SERVO_ID_PENDING until it is done.
    Status work(uint32_t slices, Tuning &tuning, Error *error = nullptr) {
        return servo_id_tuner_work(&own_, slices, &tuning, error);
    }

private:
    servo_id_tuner own_{};
};

using CommissionStep = servo_id_commission_step;
using CommissionResult = servo_id_commission_result;
using Record = servo_id_record;
using Decision = servo_id_decision;

// The interrupt's half of a commissioning.
class Commission {
public:
    Status init(const servo_id_settings &settings, int32_t count, float held = 0.0F, Error *error = nullptr) {
        return servo_id_commission_init(&own_, sizeof own_, &settings, count, held, error);
    }
    Status slices(uint32_t &slices) const { return servo_id_commission_slices(&own_, &slices); }
    Status sample(int32_t count, CommissionStep &step, int32_t conditions = SERVO_ID_IN_ORDER,
                  int32_t stop = SERVO_ID_NO_STOP) {
        return servo_id_commission_sample(&own_, count, conditions, stop, &step);
    }
    Status accept(const Decision &decision) { return servo_id_commission_accept(&own_, &decision); }
    Status result(CommissionResult &result) const { return servo_id_commission_get_result(&own_, &result); }

private:
    servo_id_commission own_{};
};

// Its background's half.
class Solver {
public:
    Status init(const servo_id_settings &settings, Error *error = nullptr) {
        return servo_id_solver_init(&own_, sizeof own_, &settings, error);
    }
    Status take(const Record &record) { return servo_id_solver_take(&own_, &record); }
    // SERVO_ID_DECIDED for a decision; `slices` is then the number left.
    Status work(uint32_t &slices, Decision &decision) { return servo_id_solver_work(&own_, &slices, &decision); }

private:
    servo_id_solver own_{};
};

} // namespace servo_id

#endif

// Every function of every class of the wrapper once, with the statuses that it must have.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "servo_id.hpp"

namespace {

void expect(int line, servo_id::Status status, int32_t expected) {
    if (status.number() != expected) {
        std::printf("line %d: %s\n", line, status.text());
        std::exit(1);
    }
}
#define EXPECT(CALL, STATUS) expect(__LINE__, CALL, STATUS)
// Any event of a sample.
#define TAKES(CALL) expect(__LINE__, (CALL) ? SERVO_ID_OK : SERVO_ID_SAMPLE_REFUSED, SERVO_ID_OK)

servo_id::Settings settings() {
    servo_id::Settings given(1e-3, 10000.0);
    given.kp = 9.0;
    given.kd = 0.19;
    given.ki = 4.0;
    given.limit = {-10.0, 10.0};
    given.servo_range = {{0.0, 50.0}, {110.0, 1000.0}};
    given.bounds.coulomb = {0.0, 100.0};
    EXPECT(given.choose_gamma(0.3, 0.05, 2000, true), SERVO_ID_OK);
    given.travel = {-0.3, 0.3};
    given.speed = 15.0;
    given.duration = 1.0;
    given.command = 10.0;
    given.step = 0.1;
    return given;
}

const uint32_t OF_ANOTHER_VERSION[] = {0xffffffff, 2, 3};

template <class Identifier, class Number> void listen(Number command, int32_t before_motion) {
    Identifier own;
    servo_id::Estimates found{};
    Number machine[4];
    EXPECT(own.sample(0, command), SERVO_ID_NOT_INITIALISED);
    EXPECT(own.init(settings()), SERVO_ID_OK);
    TAKES(own.sample(1, command));
    EXPECT(own.resume(1), SERVO_ID_OK);
    EXPECT(own.estimates(found), before_motion);
    EXPECT(own.machine_estimates(machine), before_motion);
    EXPECT(own.init(OF_ANOTHER_VERSION), SERVO_ID_CONSTANTS_VERSION);
}

template <class Loop, class Number> void close() {
    Loop own;
    Number command{};
    Number machine[4];
    servo_id::Estimates found{};
    EXPECT(own.init(settings(), 0), SERVO_ID_OK);
    EXPECT(own.control(10, Number{}, 1, command), SERVO_ID_OK);
    TAKES(own.learn(command));
    EXPECT(own.learn(command), SERVO_ID_NO_SAMPLE);
    TAKES(own.process(10, Number{}, 2, command));
    own.estimates(found);
    own.machine_estimates(machine);
    EXPECT(own.init(OF_ANOTHER_VERSION, 0), SERVO_ID_CONSTANTS_VERSION);
}

} // namespace

int main() {
    using namespace servo_id;
    GradientLoop without_pid;
    Error error{};
    EXPECT(without_pid.init(Settings(1e-3, 10000.0), 0, &error), SERVO_ID_NOT_GIVEN);
    EXPECT(std::strcmp(error.parameter, "kp") == 0 ? SERVO_ID_OK : SERVO_ID_NOT_GIVEN, SERVO_ID_OK);
    listen<Gradient>(0.0F, SERVO_ID_OK);
    listen<GradientCoulomb>(0.0F, SERVO_ID_OK);
    listen<GaussNewton>(0.0F, SERVO_ID_NO_FIT);
    listen<Fixed>(int32_t{0}, SERVO_ID_OK);
    listen<FixedCoulomb>(int32_t{0}, SERVO_ID_OK);
    close<GradientLoop, float>();
    close<GradientCoulombLoop, float>();
    close<GaussNewtonLoop, float>();
    close<FixedLoop, int32_t>();
    close<FixedCoulombLoop, int32_t>();

    GaussNewton identifier;
    FixedLoop fixed;
    double scale = 0.0;
    EXPECT(identifier.init(settings()), SERVO_ID_OK);
    TAKES(identifier.learn(0.5F, 0.0F));
    EXPECT(identifier.work(10), SERVO_ID_OK);
    EXPECT(fixed.init(settings(), 0), SERVO_ID_OK);
    EXPECT(fixed.scale(scale), SERVO_ID_OK);

    const Estimates known{{2.0, 257.7, 10.0, 0.0}, {0.01, 0.5, 0.1, 0.1}, {0, 0, 0, 0}};
    Verdict verdict{};
    Servo servo{};
    EXPECT(judge(known, 1.0, 10.0, verdict), SERVO_ID_OK);
    expect(__LINE__, verdict.known, 1);
    EXPECT(servo_from(known, 1e-3, 2e-4, servo), SERVO_ID_OK);
    Tuner tuner;
    Tuning gains{};
    EXPECT(tuner.init(settings(), servo), SERVO_ID_OK);
    EXPECT(tuner.work(1, gains), SERVO_ID_PENDING);
    EXPECT(tuner.work(20000, gains), SERVO_ID_OK);

    Commission commission;
    Solver solver;
    CommissionStep step{};
    CommissionResult result{};
    Decision decision{};
    uint32_t slices = 0;
    EXPECT(commission.init(settings(), 0), SERVO_ID_OK);
    EXPECT(commission.slices(slices), SERVO_ID_OK);
    EXPECT(commission.sample(0, step), SERVO_ID_OK);
    EXPECT(commission.result(result), SERVO_ID_OK);
    EXPECT(commission.accept(decision), SERVO_ID_NOT_INITIALISED);
    EXPECT(solver.init(settings()), SERVO_ID_OK);
    EXPECT(solver.take(Record{}), SERVO_ID_NOT_INITIALISED);
    EXPECT(solver.work(slices, decision), SERVO_ID_PENDING);
    return 0;
}

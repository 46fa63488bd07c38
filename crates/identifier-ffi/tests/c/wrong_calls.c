/* Calls that C refuses nowhere: each has its status, also under the compiler's sanitizers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "servo_id.h"

static void expect(int line, int32_t answered, int32_t expected) {
    if (answered != expected) {
        printf("line %d: status %d in place of %d\n", line, (int)answered, (int)expected);
        exit(1);
    }
}
#define EXPECT(CALL, STATUS) expect(__LINE__, CALL, STATUS)
/* A refusal about a field of the settings. */
#define REFUSED(CALL, STATUS, FIELD)                                                                                   \
    EXPECT(CALL, STATUS);                                                                                              \
    EXPECT(error.status, STATUS);                                                                                      \
    EXPECT(error.parameter != NULL && strcmp(error.parameter, FIELD) == 0, 1)

/* Settings that every estimator accepts, in which one of these is changed. */
static const servo_id_settings RIGHT = {
    .sample_time = 1e-3,
    .counts_per_revolution = 1e4,
    .kp = 9.0,
    .kd = 0.19,
    .ki = 4.0,
    .limit = {-10.0, 10.0},
    .gamma = {23.0, 1700.0, 100.0, 0.0},
    .bounds = {.coulomb = {0.0, 100.0}},
    .servo_range = {.a = {0.0, 50.0}, .b = {110.0, 1000.0}},
    .travel = {-0.3, 0.3},
    .speed = 15.0,
    .duration = 1.0,
};
#define CHANGED(FIELD, VALUE, STATUS, NAME, ALLOWED)                                                                   \
    do {                                                                                                               \
        static servo_id_gradient object;                                                                               \
        servo_id_settings given = RIGHT;                                                                               \
        given.FIELD = VALUE;                                                                                           \
        REFUSED(servo_id_gradient_init(&object, sizeof object, &given, &error), STATUS, NAME);                         \
        EXPECT(error.allowed, ALLOWED);                                                                                \
        EXPECT(servo_id_gradient_sample(&object, 0, 0.0f), SERVO_ID_NOT_INITIALISED);                                  \
    } while (0)

/* A refusal names the field and what is allowed. */
static void settings_are_refused(void) {
    servo_id_error error;
    CHANGED(sample_time, 1e9, SERVO_ID_OUT_OF_RANGE, "sample_time", SERVO_ID_ALLOWED_WITHIN);
    EXPECT(error.value == 1e9 && error.low < error.high && error.high < 1e9, 1);
    CHANGED(mu, 1000.0, SERVO_ID_CERTIFICATE, "mu", SERVO_ID_ALLOWED_BELOW);
    EXPECT(error.value == 1000.0 && error.high < 1000.0, 1);
    CHANGED(gamma.b, -1.0, SERVO_ID_GAMMA, "gamma.b", SERVO_ID_ALLOWED_ABOVE);
    CHANGED(initial.b, -1.0, SERVO_ID_OUT_OF_RANGE, "initial.b", SERVO_ID_ALLOWED_WITHIN);
    CHANGED(sample_time, 0.0, SERVO_ID_NOT_GIVEN, "sample_time", SERVO_ID_ALLOWED_UNKNOWN);
    CHANGED(counts_per_revolution, 0.0, SERVO_ID_NOT_GIVEN, "counts_per_revolution", SERVO_ID_ALLOWED_UNKNOWN);
    CHANGED(ranges.error, 1.0, SERVO_ID_NOT_GIVEN, "ranges.velocity", SERVO_ID_ALLOWED_UNKNOWN);
    CHANGED(servo_range.a, (servo_id_range){0}, SERVO_ID_NOT_GIVEN, "servo_range.a", SERVO_ID_ALLOWED_UNKNOWN);
}

/* The friction of a servo with 10 rad/s^2 of it; zero only where it is stated to be known. */
static double friction(int32_t known) {
    static servo_id_gauss_newton object;
    servo_id_settings given = RIGHT;
    servo_id_estimates found = {0};
    double position = 0.0, velocity = 0.0;
    int32_t last = 0;
    given.known.coulomb = known;
    EXPECT(servo_id_gauss_newton_init(&object, sizeof object, &given, NULL), SERVO_ID_OK);
    for (int sample = 0; sample < 4000; sample++) {
        double command = sample / 120 % 2 == 0 ? 0.5 : -0.5;
        int32_t count = (int32_t)floor(position * 1e4 / 6.283185307179586);
        servo_id_gauss_newton_sample(&object, count - last, (float)command);
        servo_id_gauss_newton_work(&object, 8);
        last = count;
        double pushed = velocity + 1e-3 * (200.0 * command - 2.0 * velocity);
        double next = copysign(fmax(fabs(pushed) - 0.01, 0.0), pushed);
        position += 0.5e-3 * (velocity + next);
        velocity = next;
    }
    servo_id_gauss_newton_estimates(&object, &found);
    return found.value[2];
}

/* A loop learns from the last sample or from none: _process is one whole, and so is a sample that is refused. */
#define LEARNS_ONCE(NAME, NUMBER)                                                                                      \
    do {                                                                                                               \
        static servo_id_##NAME object;                                                                                 \
        NUMBER command;                                                                                                \
        EXPECT(servo_id_##NAME##_init(&object, sizeof object, &RIGHT, 0, NULL), SERVO_ID_OK);                          \
        EXPECT(servo_id_##NAME##_control(&object, 3, 0, 0, &command), SERVO_ID_OK);                                    \
        EXPECT(servo_id_##NAME##_process(&object, 3, 0, 1, &command) >= 0, 1);                                         \
        EXPECT(servo_id_##NAME##_learn(&object, command), SERVO_ID_NO_SAMPLE);                                         \
        EXPECT(servo_id_##NAME##_control(&object, 3, 0, 1, &command), SERVO_ID_OK);                                    \
        servo_id_##NAME##_process(&object, INT32_MAX, 0, 1, &command);                                                 \
        EXPECT(servo_id_##NAME##_learn(&object, command), SERVO_ID_NO_SAMPLE);                                         \
    } while (0)

/* A sample of a motor that is driven, and whether it is still driven with this command. */
static int32_t sampled(servo_id_commission *commission, int32_t count, int32_t stop, float driven) {
    servo_id_commission_step step = {.command = 7.02f, .is_enabled = 1, .has_record = 1};
    int32_t answered = servo_id_commission_sample(commission, count, 0, stop, &step);
    EXPECT(fabsf(step.command - driven) < 0.01f && step.is_enabled == (driven != 0.0f), 1);
    EXPECT(answered < 0 && step.has_record, 0);
    return answered;
}

/* A stop by any number disables the stage for good. */
static void stops_for_good(int32_t stop) {
    static servo_id_commission commission;
    servo_id_commission_result result;
    EXPECT(servo_id_commission_init(&commission, sizeof commission, &RIGHT, 0, 7.02f, NULL), SERVO_ID_OK);
    EXPECT(sampled(&commission, 0, 0, 7.02f), SERVO_ID_OK);
    EXPECT(sampled(&commission, 0, stop, 0.0f), stop == 170 ? SERVO_ID_OK : SERVO_ID_NO_SUCH_NUMBER);
    for (int32_t count = 0; count < 50; count++) {
        EXPECT(sampled(&commission, count, 0, 0.0f), SERVO_ID_OK);
    }
    EXPECT(servo_id_commission_get_result(&commission, &result), SERVO_ID_OK);
    EXPECT(result.phase, SERVO_ID_PHASE_ABORTED);
    EXPECT(result.reason, 170);
}

int main(void) {
    settings_are_refused();
    EXPECT(fabs(friction(0) - 10.0) < 2.0, 1);
    EXPECT(friction(1) == 0.0, 1);
    LEARNS_ONCE(gradient_loop, float);
    LEARNS_ONCE(fixed_loop, int32_t);
    static const int32_t stops[] = {255, 256, -1, INT32_MIN, INT32_MAX, 99, 170};
    for (size_t place = 0; place < sizeof stops / sizeof *stops; place++) {
        stops_for_good(stops[place]);
    }
    static servo_id_commission none;
    EXPECT(sampled(&none, 0, 0, 0.0f), SERVO_ID_NOT_INITIALISED);
    EXPECT(sampled(NULL, 0, 0, 0.0f), SERVO_ID_NULL_POINTER);

    servo_id_settings settings = {0};
    servo_id_gauss_newton *object = malloc(sizeof *object), *copy = malloc(sizeof *object);
    servo_id_estimates found;
    servo_id_error error;
    float command = 1.0f;
    const char *text = NULL;
    memset(object, 0, sizeof *object);

    /* Before initialisation. */
    EXPECT(servo_id_gauss_newton_sample(object, 1, 0.0f), SERVO_ID_NOT_INITIALISED);
    EXPECT(servo_id_gauss_newton_work(object, 1), SERVO_ID_NOT_INITIALISED);
    EXPECT(servo_id_gauss_newton_estimates(object, &found), SERVO_ID_NOT_INITIALISED);

    /* Settings that lack something, that are none, and too little storage. */
    REFUSED(servo_id_gauss_newton_init(object, sizeof *object, &settings, &error), SERVO_ID_NOT_GIVEN, "sample_time");
    settings.sample_time = 1e-3;
    REFUSED(servo_id_gauss_newton_init(object, sizeof *object, &settings, &error), SERVO_ID_NOT_GIVEN,
            "counts_per_revolution");
    settings.counts_per_revolution = 4096.0;
    settings.sample_time = NAN;
    REFUSED(servo_id_gauss_newton_init(object, sizeof *object, &settings, &error), SERVO_ID_OUT_OF_RANGE, "sample_time");
    settings.sample_time = 1e-3;
    EXPECT(servo_id_gauss_newton_init(object, sizeof *object - 8, &settings, NULL), SERVO_ID_TOO_SMALL);

    /* No memory, or none of the kind. */
    EXPECT(servo_id_gauss_newton_init(NULL, sizeof *object, &settings, NULL), SERVO_ID_NULL_POINTER);
    EXPECT(servo_id_gauss_newton_init((servo_id_gauss_newton *)(uintptr_t)((uintptr_t)object + 4), sizeof *object,
                                      &settings, NULL),
           SERVO_ID_MISALIGNED);
    EXPECT(servo_id_gauss_newton_init(object, sizeof *object, NULL, NULL), SERVO_ID_NULL_POINTER);
    EXPECT(servo_id_gauss_newton_sample(NULL, 1, 0.0f), SERVO_ID_NULL_POINTER);
    EXPECT(servo_id_status_text(0, NULL), SERVO_ID_NULL_POINTER);

    /* Right, wrong samples, and right again. */
    EXPECT(servo_id_gauss_newton_init(object, sizeof *object, &settings, NULL), SERVO_ID_OK);
    EXPECT(servo_id_gauss_newton_sample(object, 1, NAN), SERVO_ID_COMMAND_NOT_FINITE);
    EXPECT(servo_id_gauss_newton_sample(object, INT32_MAX, 0.0f), SERVO_ID_COUNT_JUMPED);
    EXPECT(servo_id_gauss_newton_sample(object, 1, 0.0f), SERVO_ID_OK);
    EXPECT(servo_id_gauss_newton_estimates(object, NULL), SERVO_ID_NULL_POINTER);
    EXPECT(servo_id_gauss_newton_estimates(object, &found), SERVO_ID_NO_FIT);

    /* A copy lives by itself. */
    memcpy(copy, object, sizeof *object);
    memset(object, 0xff, sizeof *object);
    free(object);
    EXPECT(servo_id_gauss_newton_sample(copy, 1, 0.0f), SERVO_ID_OK);

    /* Constants of another version, of another object, and none. */
    static const uint32_t constants[] = {1024, 2, 3};
    servo_id_fixed fixed = {{0}};
    EXPECT(servo_id_fixed_init_from_constants(&fixed, sizeof fixed, NULL, 3), SERVO_ID_NULL_POINTER);
    EXPECT(servo_id_fixed_init_from_constants(&fixed, sizeof fixed, constants, 3), SERVO_ID_CONSTANTS_TYPE);
    EXPECT(servo_id_fixed_init_from_constants(&fixed, sizeof fixed, constants + 1, 2), SERVO_ID_CONSTANTS_VERSION);
    EXPECT(servo_id_fixed_init_from_constants(&fixed, sizeof fixed, constants, 0), SERVO_ID_CONSTANTS_CHANGED);
    EXPECT(servo_id_fixed_sample(&fixed, 0, 0), SERVO_ID_NOT_INITIALISED);

    /* Of another type; a loop without a PID; a refused loop commands nothing. */
    EXPECT(servo_id_gradient_sample((servo_id_gradient *)copy, 1, 0.0f), SERVO_ID_NOT_INITIALISED);
    free(copy);
    servo_id_gradient_loop loop = {{0}};
    EXPECT(servo_id_gradient_loop_init(&loop, sizeof loop, &settings, 0, &error), SERVO_ID_NOT_GIVEN);
    EXPECT(servo_id_gradient_loop_process(&loop, 0, 0.0f, 0, &command), SERVO_ID_NOT_INITIALISED);
    EXPECT(command == 0.0f, 1);
    EXPECT(servo_id_gradient_loop_process(&loop, 0, 0.0f, 0, NULL), SERVO_ID_NULL_POINTER);

    /* A commissioning without limits; a half that is none; a reason that is none. */
    static servo_id_commission commission;
    static servo_id_solver solver;
    servo_id_record record = {{0}};
    servo_id_commission_step step;
    uint32_t slices = 3;
    servo_id_decision decision;
    REFUSED(servo_id_commission_init(&commission, sizeof commission, &settings, 0, 0.0f, &error), SERVO_ID_NOT_GIVEN,
            "travel");
    EXPECT(servo_id_commission_sample(&commission, 0, 0, 0, &step), SERVO_ID_NOT_INITIALISED);
    settings.travel = (servo_id_range){-0.5, 0.5};
    settings.limit = (servo_id_range){-1.0, 1.0};
    settings.speed = 20.0;
    settings.duration = -1.0;
    REFUSED(servo_id_commission_init(&commission, sizeof commission, &settings, 0, 0.0f, &error), SERVO_ID_OUT_OF_RANGE,
            "duration");
    settings.duration = 1.0;
    EXPECT(servo_id_commission_init(&commission, sizeof commission, &settings, 0, 0.0f, &error), SERVO_ID_OK);
    EXPECT(servo_id_commission_sample(&commission, 0, 0, 255, &step), SERVO_ID_NO_SUCH_NUMBER);
    EXPECT(servo_id_commission_sample(&commission, 0, 0, 0, NULL), SERVO_ID_NULL_POINTER);
    EXPECT(servo_id_commission_sample(&commission, 0, 0, 0, &step), SERVO_ID_OK);
    EXPECT(servo_id_solver_init(&solver, sizeof solver, &settings, NULL), SERVO_ID_OK);
    EXPECT(servo_id_solver_take(&solver, &record), SERVO_ID_NOT_INITIALISED);
    EXPECT(servo_id_solver_work(&solver, &slices, &decision), SERVO_ID_PENDING);
    EXPECT(servo_id_commission_accept(&commission, &decision), SERVO_ID_NOT_INITIALISED);
    EXPECT(servo_id_reason_cause(10, &text, &slices), SERVO_ID_OK);
    EXPECT(slices > 10 && text != NULL, 1);

    /* Every status has a sentence. */
    for (int32_t status = -50; status < 50; status++) {
        EXPECT(servo_id_status_text(status, &text) <= 0 && strlen(text) > 3, 1);
    }
    return 0;
}

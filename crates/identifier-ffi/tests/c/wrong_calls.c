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

int main(void) {
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

/* A servo under every law of the library: prints for each the bits of its estimates, and sums of all commands and
 * statuses, first built from settings, then from the constants of constants.h, which a PC has computed. The arithmetic is
 * such that every machine has the same bits, and reference.rs has the same. */
#include <stdio.h>
#include <string.h>

#include "constants.h"
#include "servo_id.h"

#define SAMPLES 12000

typedef struct {
    double position; /* rad */
    double velocity;
    double load;
    uint32_t noise;
    int32_t setpoint;
    uint64_t commands; /* sum over all samples */
    uint64_t statuses;
} world;

static const double TIME = 1e-3;
static const double RADIAN_COUNTS = 10000.0 / 6.283185307179586;

static int32_t count(const world *at) { return (int32_t)(at->position * RADIAN_COUNTS + 65536.0) - 65536; }

static void sum(uint64_t *to, uint64_t next) { *to = (*to ^ next) * 1099511628211u; }

/* The next setpoint, counts. */
static void begin(world *at, int sample) {
    if (sample % 60 == 0) {
        at->noise = at->noise * 1664525u + 1013904223u;
        at->setpoint = (int32_t)(at->noise >> 22) - 512;
    }
}

/* The servo under a command until the next sample. */
static void advance(world *at, double command, double coulomb) {
    double push = 257.7 * command - 2.0 * at->velocity + at->load;
    double free = at->velocity + TIME * push;
    double rub = TIME * coulomb;
    double velocity = free > rub ? free - rub : free < -rub ? free + rub : 0.0;
    at->position += 0.5 * TIME * (at->velocity + velocity);
    at->velocity = velocity;
}

static void take(world *at, int32_t status, float command) {
    uint32_t bits;
    memcpy(&bits, &command, sizeof bits);
    sum(&at->commands, bits);
    sum(&at->statuses, (uint32_t)status);
}

/* The caller's own controller. */
static float own_command(world *at, int32_t now) {
    float error = (float)(at->setpoint - now);
    float command = 0.0055f * error - 0.19f * (float)at->velocity;
    return command > 4.0f ? 4.0f : command < -4.0f ? -4.0f : command;
}

static void print(const char *name, const world *at, const servo_id_estimates *found) {
    printf("%s", name);
    for (int place = 0; place < 4; place++) {
        uint64_t bits;
        memcpy(&bits, &found->value[place], sizeof bits);
        printf(" %08lx%08lx", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffffu));
    }
    printf(" %08lx%08lx", (unsigned long)(at->commands >> 32), (unsigned long)(at->commands & 0xffffffffu));
    printf(" %08lx%08lx\n", (unsigned long)(at->statuses >> 32), (unsigned long)(at->statuses & 0xffffffffu));
}

static servo_id_settings settings(int coulomb) {
    servo_id_settings given = {
        .sample_time = TIME,
        .counts_per_revolution = 10000.0,
        .kp = 9.0,
        .kd = 0.19,
        .ki = 4.0,
        .limit = {-10.0, 10.0},
        .servo_range = {.a = {0.0, 50.0}, .b = {110.0, 1000.0}},
        .bounds = {.coulomb = {0.0, 100.0}},
    };
    servo_id_error error;
    if (servo_id_settings_choose_gamma(&given, 0.3, 0.05, 2000, coulomb, &error) != SERVO_ID_OK) {
        printf("settings: status %d, parameter %s\n", (int)error.status, error.parameter);
    }
    return given;
}

#define WORDS(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* The estimates in machine units, float or int32_t. */
static uint32_t machine[4];

static void sum_machine(world *at, int32_t status) {
    sum(&at->statuses, (uint32_t)status);
    for (int place = 0; place < 4; place++) {
        sum(&at->statuses, machine[place]);
    }
}

/* Objects are large for a small stack. */
#define LISTENS(NAME, COULOMB, COMMAND, WORK)                                                                          \
    static void NAME(int of_constants) {                                                                               \
        static servo_id_##NAME object, copy;                                                                           \
        servo_id_settings given = settings(COULOMB);                                                                   \
        servo_id_error error = {0};                                                                                    \
        servo_id_estimates found = {0};                                                                                \
        world at = {.load = 20.0, .noise = 1};                                                                         \
        int32_t last = count(&at);                                                                                     \
        int32_t begun = of_constants ? servo_id_##NAME##_init_from_constants(&object, sizeof object, NAME##_words,     \
                                                                             WORDS(NAME##_words))                      \
                                     : servo_id_##NAME##_init(&object, sizeof object, &given, &error);                 \
        sum(&at.statuses, (uint32_t)begun);                                                                            \
        for (int sample = 0; sample < SAMPLES; sample++) {                                                             \
            begin(&at, sample);                                                                                        \
            int32_t now = count(&at);                                                                                  \
            float command = own_command(&at, now);                                                                     \
            advance(&at, command, COULOMB ? 10.0 : 0.0);                                                               \
            take(&at, servo_id_##NAME##_sample(&object, now - last, COMMAND), command);                                \
            WORK;                                                                                                      \
            last = now;                                                                                                \
            /* An object may be moved at any time. */                                                                  \
            if (sample % 1000 == 500) {                                                                                \
                memcpy(&copy, &object, sizeof copy);                                                                   \
                memset(&object, 0, sizeof object);                                                                     \
                memcpy(&object, &copy, sizeof object);                                                                 \
            }                                                                                                          \
        }                                                                                                              \
        sum(&at.statuses, (uint32_t)servo_id_##NAME##_estimates(&object, &found));                                     \
        sum_machine(&at, servo_id_##NAME##_machine_estimates(&object, (void *)machine));                               \
        print(of_constants ? #NAME "_of_constants" : #NAME, &at, &found);                                              \
    }

#define LOOPS(NAME, COULOMB, NUMBER, OFFSET, AS_FLOAT, WORK)                                                           \
    static void NAME(int of_constants) {                                                                               \
        static servo_id_##NAME object;                                                                                 \
        servo_id_settings given = settings(COULOMB);                                                                   \
        servo_id_error error = {0};                                                                                    \
        servo_id_estimates found = {0};                                                                                \
        world at = {.load = 20.0, .noise = 1};                                                                         \
        int32_t begun = of_constants ? servo_id_##NAME##_init_from_constants(&object, sizeof object, NAME##_words,     \
                                                                             WORDS(NAME##_words), 0)                   \
                                     : servo_id_##NAME##_init(&object, sizeof object, &given, 0, &error);              \
        sum(&at.statuses, (uint32_t)begun);                                                                            \
        for (int sample = 0; sample < SAMPLES; sample++) {                                                             \
            NUMBER command;                                                                                            \
            int32_t status;                                                                                            \
            begin(&at, sample);                                                                                        \
            /* Whole, and in its two halves. */                                                                        \
            if (sample < SAMPLES / 2) {                                                                                \
                status = servo_id_##NAME##_process(&object, at.setpoint, OFFSET, count(&at), &command);                \
            } else {                                                                                                   \
                servo_id_##NAME##_control(&object, at.setpoint, OFFSET, count(&at), &command);                         \
                status = servo_id_##NAME##_learn(&object, command);                                                    \
            }                                                                                                          \
            advance(&at, AS_FLOAT, COULOMB ? 10.0 : 0.0);                                                              \
            take(&at, status, (float)(AS_FLOAT));                                                                      \
            WORK;                                                                                                      \
        }                                                                                                              \
        sum(&at.statuses, (uint32_t)servo_id_##NAME##_estimates(&object, &found));                                     \
        sum_machine(&at, servo_id_##NAME##_machine_estimates(&object, (void *)machine));                               \
        print(of_constants ? #NAME "_of_constants" : #NAME, &at, &found);                                              \
    }

/* An unknown servo is commissioned: both halves in step, what goes between them as copies. */
static void commission(void) {
    static servo_id_commission object;
    static servo_id_solver solver;
    servo_id_settings given = {
        .sample_time = TIME,
        .counts_per_revolution = 10000.0,
        .travel = {-0.3, 0.3},
        .speed = 15.0,
        .limit = {-10.0, 10.0},
        .duration = 1.0,
        .loop_bandwidth = 70.0,
        .with_feed_forward = 1,
    };
    servo_id_error error = {0};
    servo_id_commission_step step = {0};
    servo_id_commission_result result = {0};
    servo_id_estimates found = {0};
    uint32_t slices = 0;
    world at = {.noise = 1};
    int32_t status = servo_id_commission_init(&object, sizeof object, &given, count(&at), 0.0f, &error);
    status |= servo_id_solver_init(&solver, sizeof solver, &given, &error);
    status |= servo_id_commission_slices(&object, &slices);
    sum(&at.statuses, (uint32_t)status);
    while (status == SERVO_ID_OK && step.phase < SERVO_ID_PHASE_APPLIED) {
        uint32_t left = slices;
        servo_id_decision decision, carried;
        servo_id_commission_sample(&object, count(&at), SERVO_ID_IN_ORDER, SERVO_ID_NO_STOP, &step);
        if (step.has_record) {
            servo_id_record record;
            memcpy(&record, &step.record, sizeof record);
            servo_id_solver_take(&solver, &record);
        }
        while (servo_id_solver_work(&solver, &left, &decision) == SERVO_ID_DECIDED) {
            memcpy(&carried, &decision, sizeof carried);
            servo_id_commission_accept(&object, &carried);
        }
        advance(&at, step.command, 10.0);
        take(&at, step.phase, step.command);
    }
    servo_id_commission_get_result(&object, &result);
    memcpy(found.value, result.servo.value, sizeof found.value);
    sum(&at.statuses, (uint32_t)result.reason);
    print("commission", &at, &found);
    found.value[0] = result.tuning.kp;
    found.value[1] = result.tuning.kd;
    found.value[2] = result.tuning.ki;
    found.value[3] = result.measured_rise_time;
    print("commission_gains", &at, &found);
}

static int32_t word(float command, double scale) { return (int32_t)((double)command / scale); }

static double fixed_scale(void) {
    static servo_id_fixed object;
    servo_id_settings given = settings(0);
    double scale = 0.0;
    servo_id_fixed_init(&object, sizeof object, &given, NULL);
    servo_id_fixed_scale(&object, &scale);
    return scale;
}

static double scale;

LISTENS(gradient, 0, command, servo_id_gradient_work(&object, 50))
LISTENS(gradient_coulomb, 1, command, servo_id_gradient_coulomb_work(&object, 50))
LISTENS(gauss_newton, 1, command, servo_id_gauss_newton_work(&object, 50))
LISTENS(fixed, 0, word(command, scale), servo_id_fixed_work(&object, 50))
LISTENS(fixed_coulomb, 1, word(command, scale), servo_id_fixed_coulomb_work(&object, 50))
LOOPS(gradient_loop, 0, float, 0.25f, command, servo_id_gradient_loop_work(&object, 50))
LOOPS(gradient_coulomb_loop, 1, float, 0.25f, command, servo_id_gradient_coulomb_loop_work(&object, 50))
LOOPS(gauss_newton_loop, 1, float, 0.25f, command, servo_id_gauss_newton_loop_work(&object, 50))
LOOPS(fixed_loop, 0, int32_t, 16384, command *scale, servo_id_fixed_loop_work(&object, 50))
LOOPS(fixed_coulomb_loop, 1, int32_t, 16384, command *scale, servo_id_fixed_coulomb_loop_work(&object, 50))

int main(void) {
    scale = fixed_scale();
    for (int of_constants = 0; of_constants < 2; of_constants++) {
        gradient(of_constants);
        gradient_coulomb(of_constants);
        gauss_newton(of_constants);
        fixed(of_constants);
        fixed_coulomb(of_constants);
        gradient_loop(of_constants);
        gradient_coulomb_loop(of_constants);
        gauss_newton_loop(of_constants);
        fixed_loop(of_constants);
        fixed_coulomb_loop(of_constants);
    }
    commission();
    return 0;
}

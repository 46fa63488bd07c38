/* A servo under a controller of ours, identified while it moves. Here the servo is a few lines of arithmetic. */
#include <math.h>
#include <stdio.h>

#include "servo_id.h"

/* The true servo: a (1/s), b (rad/s^2 per command unit), Coulomb friction and load (rad/s^2). */
static const double A = 2.0, B = 257.7, COULOMB = 6.0, LOAD = -15.0;

/* The sample time, s; counts of a revolution, and a turn, rad; the largest command and the usual speed, rad/s. */
static const double TIME = 1e-3, COUNTS = 10000.0, TURN = 6.283185307179586;
static const double LARGEST = 1.2, SPEED = 10.0;

/* Our controller: command units per count and per rad/s. It moves to and fro by so many counts, so many samples each. The
   middle drifts, counts per sample: a motion that repeats itself to a count has the same rounding each time. */
static const double KP = 0.006, KD = 0.19, DISTANCE = 400.0, DRIFT = 0.0137;
enum { SAMPLES = 8000, HELD = 170, PARTS = 100, BLOCKS = 8, SLICES = 100 };

/* What the model leaves of the position, rad, and the step that the gains are for, rad. */
static const double UNEXPLAINED = 2e-4, STEP = 0.1;

static double position, velocity; /* rad */

static int32_t read_encoder(void) { return (int32_t)floor(position / TURN * COUNTS); }

static void write_command(double command) {
    /* In parts, since the arithmetic of a single one would change b by a thousandth. */
    for (int part = 0; part < PARTS; part++) {
        double time = TIME / PARTS, rubbed = time * COULOMB;
        double pushed = velocity + time * (B * command - A * velocity + LOAD);
        double next = pushed > rubbed ? pushed - rubbed : pushed < -rubbed ? pushed + rubbed : 0.0;
        position += time * (velocity + next) / 2.0;
        velocity = next;
    }
}

static servo_id_gauss_newton identifier;
static servo_id_tuner tuner;

static int refused(const char *call, int32_t status, const servo_id_error *error) {
    const char *text;
    servo_id_status_text(status, &text);
    printf("%s: %s: %s = %g, allowed from %g to %g\n", call, text, error->parameter ? error->parameter : "", error->value,
           error->low, error->high);
    return 1;
}

int main(void) {
    const servo_id_settings settings = {
        .sample_time = TIME,
        .counts_per_revolution = COUNTS,
        .command = LARGEST,
        .step = STEP,
    };
    servo_id_error error = {0};
    int32_t status = servo_id_gauss_newton_init(&identifier, sizeof identifier, &settings, &error);
    if (status < SERVO_ID_OK) {
        return refused("identifier", status, &error);
    }
    int32_t last = read_encoder();
    for (int sample = 0; sample < SAMPLES; sample++) {
        /* Each sample, with the command that acts: after every limit. */
        int32_t now = read_encoder();
        double setpoint = DRIFT * sample + (sample / HELD % 2 ? DISTANCE : -DISTANCE);
        double command = fmin(fmax(KP * (setpoint - now) - KD * velocity, -LARGEST), LARGEST);
        servo_id_gauss_newton_sample(&identifier, now - last, (float)command);
        write_command(command);
        last = now;
        /* In the background. */
        servo_id_gauss_newton_work(&identifier, BLOCKS);
    }

    servo_id_estimates found;
    servo_id_verdict verdict;
    status = servo_id_gauss_newton_estimates(&identifier, &found);
    if (status != SERVO_ID_OK) {
        return refused("estimates", status, &error);
    }
    servo_id_judge(&found, LARGEST, SPEED, &verdict);
    printf("b = %.2f +- %.2f, Coulomb friction %.3f, load %.3f: %s\n", found.value[SERVO_ID_B],
           2.0 * found.std_error[SERVO_ID_B], found.value[SERVO_ID_COULOMB], found.value[SERVO_ID_LOAD],
           verdict.known ? "known" : "not known");

    servo_id_servo servo;
    servo_id_tuning gains;
    servo_id_servo_from_estimates(&found, 0.0, UNEXPLAINED, &servo);
    status = servo_id_tuner_init(&tuner, sizeof tuner, &settings, &servo, &error);
    while (status >= SERVO_ID_OK &&
           (status = servo_id_tuner_work(&tuner, SLICES, &gains, &error)) == SERVO_ID_PENDING) {
    }
    if (status < SERVO_ID_OK) {
        return refused("tuning", status, &error);
    }
    printf("kp = %.3f, kd = %.4f, ki = %.2f: rise time %.1f ms\n", gains.kp, gains.kd, gains.ki,
           1e3 * gains.rise_time[0]);
    return !verdict.known || fabs(found.value[SERVO_ID_B] - B) > 2.0 * found.std_error[SERVO_ID_B];
}

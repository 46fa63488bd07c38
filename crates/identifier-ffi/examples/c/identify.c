/* A servo under a controller of ours, identified while it moves. Here the servo is a few lines of arithmetic. */
#include <stdio.h>

#include "servo_id.h"

/* The true servo: a (1/s), b (rad/s^2 per command unit), Coulomb friction and load (rad/s^2). */
static const double A = 2.0, B = 257.7, COULOMB = 6.0, LOAD = -15.0;
static const double TIME = 1e-3, COUNTS = 10000.0;

static double position, velocity; /* rad */

static int32_t read_encoder(void) { return (int32_t)(position / 6.283185307179586 * COUNTS + 1e6) - 1000000; }

static void write_command(double command) {
    double pushed = velocity + TIME * (B * command - A * velocity + LOAD), rubbed = TIME * COULOMB;
    double next = pushed > rubbed ? pushed - rubbed : pushed < -rubbed ? pushed + rubbed : 0.0;
    position += TIME * (velocity + next) / 2.0;
    velocity = next;
}

static servo_id_gauss_newton identifier;
static servo_id_tuner tuner;

static int refused(const char *call, int32_t status, const servo_id_error *error) {
    const char *text, *name;
    servo_id_status_text(status, &text);
    servo_id_parameter_name(error->parameter, &name);
    printf("%s: %s: %s = %g, allowed from %g to %g\n", call, text, name, error->value, error->low, error->high);
    return 1;
}

int main(void) {
    servo_id_settings settings;
    servo_id_error error = {0};
    servo_id_settings_init(&settings, sizeof settings, TIME, COUNTS);
    int32_t status = servo_id_gauss_newton_init(&identifier, sizeof identifier, &settings, &error);
    if (status < 0) {
        return refused("identifier", status, &error);
    }
    int32_t last = read_encoder();
    for (int sample = 0; sample < 8000; sample++) {
        /* Each sample, with the command that acts: after every limit. */
        int32_t now = read_encoder();
        double setpoint = sample / 170 % 2 ? 400.0 : -400.0;
        double command = 0.006 * (setpoint - now) - 0.19 * velocity;
        command = command > 1.2 ? 1.2 : command < -1.2 ? -1.2 : command;
        servo_id_gauss_newton_sample(&identifier, now - last, (float)command);
        write_command(command);
        last = now;
        /* In the background. */
        servo_id_gauss_newton_work(&identifier, 8);
    }

    servo_id_estimates found;
    servo_id_verdict verdict;
    status = servo_id_gauss_newton_estimates(&identifier, &found);
    if (status != SERVO_ID_OK) {
        return refused("estimates", status, &error);
    }
    servo_id_judge(&found, 1.0, 10.0, &verdict);
    printf("b = %.2f +- %.2f, Coulomb friction %.3f, load %.3f: %s\n", found.value[SERVO_ID_B],
           2.0 * found.std_error[SERVO_ID_B], found.value[SERVO_ID_COULOMB], found.value[SERVO_ID_LOAD],
           verdict.known ? "known" : "not known");

    servo_id_servo servo;
    servo_id_tuning gains;
    servo_id_servo_from_estimates(&found, 0.0, 2e-4, &servo);
    servo_id_settings_set(&settings, SERVO_ID_COMMAND, 1.2);
    servo_id_settings_set(&settings, SERVO_ID_STEP, 0.1);
    status = servo_id_tuner_init(&tuner, sizeof tuner, &settings, &servo, &error);
    while (status >= 0 && (status = servo_id_tuner_work(&tuner, 100, &gains, &error)) == SERVO_ID_PENDING) {
    }
    if (status < 0) {
        return refused("tuning", status, &error);
    }
    printf("kp = %.3f, kd = %.4f, ki = %.2f: rise time %.1f ms\n", gains.kp, gains.kd, gains.ki,
           1e3 * gains.rise_time[0]);
    return !verdict.known || found.value[SERVO_ID_B] < 0.98 * B || found.value[SERVO_ID_B] > 1.02 * B;
}

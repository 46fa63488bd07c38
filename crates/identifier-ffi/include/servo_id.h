/* servo_id.h: identify the friction, gain and load of a servo axis while a controller runs it, and tune its PID.
 *
 * The servo is q'' = -a q' + b u + d - c sign(q'), with the command u that acts, in SI (for a linear axis read m for
 * rad): a in 1/s, b in rad/s^2 per command unit, Coulomb friction c and load d in rad/s^2.
 *
 * Your program owns the memory of every object: declare one and initialise it. The library has no heap, no global
 * variable and no panic. An object may be copied byte by byte, and needs no destruction.
 *
 * Every function returns a status: SERVO_ID_OK, a positive number for an event of a sample, or a negative number for an
 * error, which changes nothing. `size` is the sizeof of the object that is initialised; `error` may be NULL. Null and
 * misaligned addresses, and those of an object that is not initialised, give an error. The memory behind any other
 * address must be of its type. No other thread or interrupt may use the object during a call. Set an object of arbitrary
 * content to zero before you call anything but its initialisation.
 */
#ifndef SERVO_ID_H
#define SERVO_ID_H

#include <stddef.h>
#include <stdint.h>

/* Statuses. servo_id_status_text has a sentence for each. */
#define SERVO_ID_OK                   0
#define SERVO_ID_SLOWED               1
#define SERVO_ID_STANDING             2
#define SERVO_ID_RESTARTED            3
#define SERVO_ID_STARTED              4
#define SERVO_ID_LOAD_STEP            5
#define SERVO_ID_TERM_ENTERED         6
#define SERVO_ID_FRICTION_LOWERED     7
#define SERVO_ID_AT_BOUND             8
#define SERVO_ID_NOT_FOLLOWING        9
#define SERVO_ID_FIRST_FIT_OVERDUE   10
#define SERVO_ID_PENDING             20
#define SERVO_ID_DECIDED             21
#define SERVO_ID_NULL_POINTER        -1
#define SERVO_ID_MISALIGNED          -2
#define SERVO_ID_TOO_SMALL           -3
#define SERVO_ID_NOT_INITIALISED     -4
#define SERVO_ID_NO_SUCH_NUMBER      -5
#define SERVO_ID_NOT_A_VALUE         -6
#define SERVO_ID_NOT_A_RANGE         -7
#define SERVO_ID_OUT_OF_RANGE       -10
#define SERVO_ID_NOT_GIVEN          -11
#define SERVO_ID_GAMMA              -12
#define SERVO_ID_NO_MOTION          -13
#define SERVO_ID_CERTIFICATE        -14
#define SERVO_ID_LOOP_UNSTABLE      -15
#define SERVO_ID_ESTIMATE_UNSTABLE  -16
#define SERVO_ID_NOT_SUPPORTED      -17
#define SERVO_ID_ERROR_NOT_FINITE   -20
#define SERVO_ID_TOO_FAR_APART      -21
#define SERVO_ID_COUNT_JUMPED       -22
#define SERVO_ID_COMMAND_NOT_FINITE -23
#define SERVO_ID_SAMPLE_REFUSED     -24
#define SERVO_ID_NO_SAMPLE          -25
#define SERVO_ID_NO_FIT             -30
#define SERVO_ID_NO_STANDARD_ERRORS -31
#define SERVO_ID_TOO_FAST           -40
#define SERVO_ID_NOT_KNOWN          -41
#define SERVO_ID_DOES_NOT_ARRIVE    -42
#define SERVO_ID_CONSTANTS_VERSION  -50
#define SERVO_ID_CONSTANTS_TYPE     -51
#define SERVO_ID_CONSTANTS_CHANGED  -52

/* Parameters, for servo_id_settings_set, or servo_id_settings_set_range for a range.
 * servo_id_parameter_name has a name for each. */
#define SERVO_ID_SAMPLE_TIME           1  /* s */
#define SERVO_ID_RESOLUTION            2  /* rad of a count */
#define SERVO_ID_CUTOFF                3  /* of the velocity estimate, rad/s; default half of the sample rate */
#define SERVO_ID_KP                    4  /* command units per rad */
#define SERVO_ID_KD                    5  /* command units per rad/s */
#define SERVO_ID_KI                    6  /* command units per rad s */
#define SERVO_ID_LIMIT                 7  /* range of the command, command units */
#define SERVO_ID_INITIAL_A             8  /* 1/s */
#define SERVO_ID_INITIAL_B             9  /* rad/s^2 per command unit */
#define SERVO_ID_INITIAL_COULOMB      10  /* rad/s^2 */
#define SERVO_ID_INITIAL_LOAD         11  /* rad/s^2 */
#define SERVO_ID_KNOWN_A              12  /* not zero: stays at its initial value */
#define SERVO_ID_KNOWN_B              13
#define SERVO_ID_KNOWN_COULOMB        14
#define SERVO_ID_KNOWN_LOAD           15
#define SERVO_ID_BOUNDS_A             16  /* range */
#define SERVO_ID_BOUNDS_B             17  /* range */
#define SERVO_ID_BOUNDS_COULOMB       18  /* range */
#define SERVO_ID_BOUNDS_LOAD          19  /* range */
#define SERVO_ID_UNCERTAINTY_A        20  /* standard deviation of the initial value */
#define SERVO_ID_UNCERTAINTY_B        21
#define SERVO_ID_UNCERTAINTY_COULOMB  22
#define SERVO_ID_UNCERTAINTY_LOAD     23
#define SERVO_ID_GAMMA_A              24  /* diagonal of gamma, of the gradient estimator */
#define SERVO_ID_GAMMA_B              25
#define SERVO_ID_GAMMA_COULOMB        26
#define SERVO_ID_GAMMA_LOAD           27
#define SERVO_ID_CORRECTION_KP        28  /* gains of the correction; default those of the PID */
#define SERVO_ID_CORRECTION_KD        29
#define SERVO_ID_CORRECTION_KI        30
#define SERVO_ID_PLANT_BOX_A          31  /* parameter range that is certified */
#define SERVO_ID_PLANT_BOX_B          32  /* range */
#define SERVO_ID_MU                   33  /* 1/s */
#define SERVO_ID_BANDWIDTH            34  /* of the position loop, rad/s */
#define SERVO_ID_START_TIME           35  /* of the first fit, s */
#define SERVO_ID_MEMORY               36  /* s; default unlimited */
#define SERVO_ID_NOISE                37  /* standard deviation of the position, rad; default of a count */
#define SERVO_ID_MAX_SPEED            38  /* rad/s */
#define SERVO_ID_RANGES_ERROR         39  /* of fixed point: position error, rad */
#define SERVO_ID_RANGES_VELOCITY      40  /* rad/s */
#define SERVO_ID_RANGES_COMMAND       41  /* command units */
#define SERVO_ID_COMMAND              42  /* of a tuning: largest command beyond that for the load; default infinite */
#define SERVO_ID_COMMAND_DELAY        43  /* from the reading of the encoder to the output, s */
#define SERVO_ID_RESPONSE_TIME        44  /* goal: from 10 to 90 %, s */
#define SERVO_ID_LOOP_BANDWIDTH       45  /* goal: rad/s; without a goal the stiffest gains within the margins */
#define SERVO_ID_MAX_SENSITIVITY      46  /* default 1.6 */
#define SERVO_ID_MAX_NOISE            47  /* part of the command; default 0.03 */
#define SERVO_ID_STEP                 48  /* of the reference, for the predicted response, rad */
#define SERVO_ID_RESONANCE            49  /* lowest known, rad/s */
#define SERVO_ID_TRAVEL               50  /* of a commissioning: range about the servo's position, rad */
#define SERVO_ID_SPEED                51  /* largest, rad/s */
#define SERVO_ID_DURATION             52  /* longest of a motion, s */
#define SERVO_ID_MAX_GAIN             54  /* largest b that the servo may have; default unknown */
#define SERVO_ID_TRIAL_STEP           55  /* rad; default half of the travel */
#define SERVO_ID_REFERENCE_FILTER     56  /* of the controller: time constant, s; default none */
#define SERVO_ID_FEED_FORWARD_BANDWIDTH     57 /* of the controller: of its reference model, rad/s; default none */
#define SERVO_ID_FEED_FORWARD_ACCELERATION  58 /* 1/b, command units per rad/s^2 */
#define SERVO_ID_FEED_FORWARD_VELOCITY      59 /* a/b, command units per rad/s */
#define SERVO_ID_FEED_FORWARD_COULOMB       60 /* command units */
#define SERVO_ID_FEED_FORWARD_COULOMB_SPEED 61 /* below it linear through zero, rad/s */
#define SERVO_ID_FEED_FORWARD         62  /* of a tuning or a commissioning, not zero: reference model if the step then rises faster */
#define SERVO_ID_NOTCH                63  /* of the controller's command, rad/s; default none */

/* Ranges that are allowed, with low and high of servo_id_error. */
#define SERVO_ID_ALLOWED_UNKNOWN          0
#define SERVO_ID_ALLOWED_FINITE           1
#define SERVO_ID_ALLOWED_ABOVE            2
#define SERVO_ID_ALLOWED_AT_LEAST         3
#define SERVO_ID_ALLOWED_BELOW            4
#define SERVO_ID_ALLOWED_AT_MOST          5
#define SERVO_ID_ALLOWED_BETWEEN          6
#define SERVO_ID_ALLOWED_WITHIN           7
#define SERVO_ID_ALLOWED_POSITIVE_UP_TO   8
#define SERVO_ID_ALLOWED_MULTIPLE_OF      9
#define SERVO_ID_ALLOWED_NEAREST         10

/* Places of the parameters in arrays. */
#define SERVO_ID_A         0
#define SERVO_ID_B         1
#define SERVO_ID_COULOMB   2
#define SERVO_ID_LOAD      3

/* States of an estimate in a verdict. */
#define SERVO_ID_KNOWN         0
#define SERVO_ID_UNCERTAIN     1
#define SERVO_ID_IS_AT_BOUND   2

/* What keeps a tuned loop from being faster. */
#define SERVO_ID_CAP_NONE             0
#define SERVO_ID_CAP_DELAY            1
#define SERVO_ID_CAP_ENCODER_NOISE    2
#define SERVO_ID_CAP_COMMAND_LIMIT    3
#define SERVO_ID_CAP_RESONANCE        4
#define SERVO_ID_CAP_UNSEEN_RESONANCE 5

/* Phases of a commissioning; the last three are ends. */
#define SERVO_ID_PHASE_IDLE                  0
#define SERVO_ID_PHASE_REST                  1
#define SERVO_ID_PHASE_PROBE                 2
#define SERVO_ID_PHASE_FIT                   3
#define SERVO_ID_PHASE_PROBE_AGAIN           4
#define SERVO_ID_PHASE_FREQUENCY_RESPONSE    5
#define SERVO_ID_PHASE_GAINS                 6
#define SERVO_ID_PHASE_TRIAL                 7
#define SERVO_ID_PHASE_APPLIED               8
#define SERVO_ID_PHASE_ROLLED_BACK           9
#define SERVO_ID_PHASE_ABORTED              10

/* Conditions of a sample of a commissioning, which are added. */
#define SERVO_ID_NO_COUNT 1  /* the encoder gave no valid reading */
#define SERVO_ID_LATE     2  /* the sample before ended too late */

/* A refusal as numbers. */
typedef struct servo_id_error {
    int32_t status;
    int32_t parameter; /* its number, zero for none */
    int32_t allowed;   /* SERVO_ID_ALLOWED_... */
    int32_t unused;
    double value; /* that was refused */
    double low;   /* allowed; of SERVO_ID_ALLOWED_MULTIPLE_OF the step, of _NEAREST what would do */
    double high;
} servo_id_error;

/* Estimates of a, b, Coulomb friction and load. */
typedef struct servo_id_estimates {
    double value[4];     /* zero for a parameter that the model does not have */
    double std_error[4]; /* NaN if the estimator has none */
    int32_t at_bound[4]; /* one for an estimate at a bound, which is not valid */
} servo_id_estimates;

/* The verdict in short. */
typedef struct servo_id_verdict {
    int32_t known;    /* one if every estimate is within tolerance */
    int32_t state[4]; /* SERVO_ID_KNOWN, SERVO_ID_UNCERTAIN, SERVO_ID_IS_AT_BOUND */
} servo_id_verdict;

/* An identified servo. */
typedef struct servo_id_servo {
    double value[4];
    double delay;            /* from a command to its acceleration besides the hold's, s */
    double covariance[5][5]; /* of a, b, Coulomb friction, delay, load; zero for known ones */
    double unexplained;      /* standard deviation of the position that the model leaves unexplained, rad */
} servo_id_servo;

/* Gains, and their predicted response. */
typedef struct servo_id_tuning {
    double kp;
    double kd;
    double ki;
    double cutoff;    /* of the velocity estimate, rad/s */
    double reference_filter; /* time constant, s; 0 for none */
    double notch;     /* filter of the command, rad/s; 0 for none */
    double feed_forward[5];  /* SERVO_ID_FEED_FORWARD_BANDWIDTH and the four after it; 0 for none */
    double bandwidth; /* of the poles, rad/s */
    double step;      /* of the predicted response, rad */
    double rise_time[3]; /* from 10 to 90 %, s: from balanced friction; after a motion with the step; after one against it */
    double overshoot;    /* part of the step */
    double settling_time;  /* to 2 % of the step, s */
    double sensitivity;    /* the largest, for every servo within the errors */
    double gain_margin[2]; /* the loop's gain may fall and rise by these factors */
    double command_share;  /* largest command, as a part of the available */
    double noise;          /* in the command, standard deviation */
    double compliance;     /* rad per rad/s^2 of a load step */
    int32_t cap;           /* SERVO_ID_CAP_... */
    int32_t unused;
} servo_id_tuning;

/* Objects. */
#ifdef __cplusplus
#define SERVO_ID_ALIGNED alignas(8)
#define SERVO_ID_ASSERT static_assert
#define SERVO_ID_ALIGNMENT alignof
#else
#define SERVO_ID_ALIGNED _Alignas(8)
#define SERVO_ID_ASSERT _Static_assert
#define SERVO_ID_ALIGNMENT _Alignof
#endif

/* Parameters that were given */
typedef struct servo_id_settings {
    SERVO_ID_ALIGNED uint64_t words[144];
} servo_id_settings;

/* The paper's estimator of a and b; its correction balances the load */
typedef struct servo_id_gradient {
    SERVO_ID_ALIGNED uint64_t words[52];
} servo_id_gradient;

/* The same with Coulomb friction */
typedef struct servo_id_gradient_coulomb {
    SERVO_ID_ALIGNED uint64_t words[66];
} servo_id_gradient_coulomb;

/* Recursive Gauss-Newton for a, b, Coulomb friction and load */
typedef struct servo_id_gauss_newton {
    SERVO_ID_ALIGNED uint64_t words[680];
} servo_id_gauss_newton;

/* The paper's estimator of a and b in fixed point */
typedef struct servo_id_fixed {
    SERVO_ID_ALIGNED uint64_t words[64];
} servo_id_fixed;

/* The same with Coulomb friction */
typedef struct servo_id_fixed_coulomb {
    SERVO_ID_ALIGNED uint64_t words[80];
} servo_id_fixed_coulomb;

/* PID with the estimator of servo_id_gradient */
typedef struct servo_id_gradient_loop {
    SERVO_ID_ALIGNED uint64_t words[76];
} servo_id_gradient_loop;

/* PID with the estimator of servo_id_gradient_coulomb */
typedef struct servo_id_gradient_coulomb_loop {
    SERVO_ID_ALIGNED uint64_t words[90];
} servo_id_gradient_coulomb_loop;

/* PID with Gauss-Newton */
typedef struct servo_id_gauss_newton_loop {
    SERVO_ID_ALIGNED uint64_t words[690];
} servo_id_gauss_newton_loop;

/* PID and estimator in fixed point */
typedef struct servo_id_fixed_loop {
    SERVO_ID_ALIGNED uint64_t words[92];
} servo_id_fixed_loop;

/* The same with Coulomb friction */
typedef struct servo_id_fixed_coulomb_loop {
    SERVO_ID_ALIGNED uint64_t words[108];
} servo_id_fixed_coulomb_loop;

/* A search for gains */
typedef struct servo_id_tuner {
    SERVO_ID_ALIGNED uint64_t words[312];
} servo_id_tuner;

/* The interrupt's half of a commissioning. */
typedef struct servo_id_commission {
    SERVO_ID_ALIGNED uint64_t words[660];
} servo_id_commission;

/* Its background's half. */
typedef struct servo_id_solver {
    SERVO_ID_ALIGNED uint64_t words[1900];
} servo_id_solver;

/* From the interrupt to the background. */
typedef struct servo_id_record {
    SERVO_ID_ALIGNED uint64_t words[4];
} servo_id_record;

/* From the background to the interrupt. */
typedef struct servo_id_decision {
    SERVO_ID_ALIGNED uint64_t words[80];
} servo_id_decision;

/* A sample of a commissioning. */
typedef struct servo_id_commission_step {
    float command;      /* that acts until the next sample; zero if the stage must be disabled */
    int32_t is_enabled; /* one if the stage must be enabled */
    int32_t phase;      /* SERVO_ID_PHASE_... */
    int32_t has_record; /* one if there is a record for the background */
    servo_id_record record;
} servo_id_commission_step;

/* The results of a commissioning so far. */
typedef struct servo_id_commission_result {
    int32_t phase;
    int32_t reason; /* why it ended without new gains, zero for none: servo_id_reason_cause */
    int32_t has_servo;
    int32_t has_tuning;
    servo_id_servo servo;
    servo_id_tuning tuning;
    double measured_rise_time; /* of the trial, s; NaN for none */
    double measured_overshoot; /* part of the step */
} servo_id_commission_result;

/* The library has the same sizes and places; objects have room for its next versions. */
SERVO_ID_ASSERT(sizeof(servo_id_settings) == 1152, "size of servo_id_settings");
SERVO_ID_ASSERT(sizeof(servo_id_gradient) == 416, "size of servo_id_gradient");
SERVO_ID_ASSERT(sizeof(servo_id_gradient_coulomb) == 528, "size of servo_id_gradient_coulomb");
SERVO_ID_ASSERT(sizeof(servo_id_gauss_newton) == 5440, "size of servo_id_gauss_newton");
SERVO_ID_ASSERT(sizeof(servo_id_fixed) == 512, "size of servo_id_fixed");
SERVO_ID_ASSERT(sizeof(servo_id_fixed_coulomb) == 640, "size of servo_id_fixed_coulomb");
SERVO_ID_ASSERT(sizeof(servo_id_gradient_loop) == 608, "size of servo_id_gradient_loop");
SERVO_ID_ASSERT(sizeof(servo_id_gradient_coulomb_loop) == 720, "size of servo_id_gradient_coulomb_loop");
SERVO_ID_ASSERT(sizeof(servo_id_gauss_newton_loop) == 5520, "size of servo_id_gauss_newton_loop");
SERVO_ID_ASSERT(sizeof(servo_id_fixed_loop) == 736, "size of servo_id_fixed_loop");
SERVO_ID_ASSERT(sizeof(servo_id_fixed_coulomb_loop) == 864, "size of servo_id_fixed_coulomb_loop");
SERVO_ID_ASSERT(sizeof(servo_id_tuner) == 2496, "size of servo_id_tuner");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_settings) == 8, "alignment of servo_id_settings");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_gradient) == 8, "alignment of servo_id_gradient");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_gradient_coulomb) == 8, "alignment of servo_id_gradient_coulomb");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_gauss_newton) == 8, "alignment of servo_id_gauss_newton");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_fixed) == 8, "alignment of servo_id_fixed");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_fixed_coulomb) == 8, "alignment of servo_id_fixed_coulomb");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_gradient_loop) == 8, "alignment of servo_id_gradient_loop");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_gradient_coulomb_loop) == 8, "alignment of servo_id_gradient_coulomb_loop");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_gauss_newton_loop) == 8, "alignment of servo_id_gauss_newton_loop");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_fixed_loop) == 8, "alignment of servo_id_fixed_loop");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_fixed_coulomb_loop) == 8, "alignment of servo_id_fixed_coulomb_loop");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_tuner) == 8, "alignment of servo_id_tuner");
SERVO_ID_ASSERT(sizeof(servo_id_commission) == 5280, "size of servo_id_commission");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_commission) == 8, "alignment of servo_id_commission");
SERVO_ID_ASSERT(sizeof(servo_id_solver) == 15200, "size of servo_id_solver");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_solver) == 8, "alignment of servo_id_solver");
SERVO_ID_ASSERT(sizeof(servo_id_record) == 32, "size of servo_id_record");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_record) == 8, "alignment of servo_id_record");
SERVO_ID_ASSERT(sizeof(servo_id_decision) == 640, "size of servo_id_decision");
SERVO_ID_ASSERT(SERVO_ID_ALIGNMENT(servo_id_decision) == 8, "alignment of servo_id_decision");
SERVO_ID_ASSERT(sizeof(servo_id_commission_step) == 48, "size of servo_id_commission_step");
SERVO_ID_ASSERT(offsetof(servo_id_commission_step, record) == 16, "place of record");
SERVO_ID_ASSERT(sizeof(servo_id_commission_result) == 480, "size of servo_id_commission_result");
SERVO_ID_ASSERT(offsetof(servo_id_commission_result, tuning) == 264, "place of tuning");
SERVO_ID_ASSERT(offsetof(servo_id_commission_result, measured_rise_time) == 464, "place of measured_rise_time");
SERVO_ID_ASSERT(sizeof(servo_id_error) == 40, "size of servo_id_error");
SERVO_ID_ASSERT(offsetof(servo_id_error, value) == 16, "place of value");
SERVO_ID_ASSERT(offsetof(servo_id_error, low) == 24, "place of low");
SERVO_ID_ASSERT(offsetof(servo_id_error, high) == 32, "place of high");
SERVO_ID_ASSERT(sizeof(servo_id_estimates) == 80, "size of servo_id_estimates");
SERVO_ID_ASSERT(offsetof(servo_id_estimates, std_error) == 32, "place of std_error");
SERVO_ID_ASSERT(offsetof(servo_id_estimates, at_bound) == 64, "place of at_bound");
SERVO_ID_ASSERT(sizeof(servo_id_verdict) == 20, "size of servo_id_verdict");
SERVO_ID_ASSERT(offsetof(servo_id_verdict, state) == 4, "place of state");
SERVO_ID_ASSERT(sizeof(servo_id_servo) == 248, "size of servo_id_servo");
SERVO_ID_ASSERT(offsetof(servo_id_servo, delay) == 32, "place of delay");
SERVO_ID_ASSERT(offsetof(servo_id_servo, covariance) == 40, "place of covariance");
SERVO_ID_ASSERT(offsetof(servo_id_servo, unexplained) == 240, "place of unexplained");
SERVO_ID_ASSERT(sizeof(servo_id_tuning) == 200, "size of servo_id_tuning");
SERVO_ID_ASSERT(offsetof(servo_id_tuning, step) == 96, "place of step");
SERVO_ID_ASSERT(offsetof(servo_id_tuning, rise_time) == 104, "place of rise_time");
SERVO_ID_ASSERT(offsetof(servo_id_tuning, overshoot) == 128, "place of overshoot");
SERVO_ID_ASSERT(offsetof(servo_id_tuning, gain_margin) == 152, "place of gain_margin");
SERVO_ID_ASSERT(offsetof(servo_id_tuning, compliance) == 184, "place of compliance");
SERVO_ID_ASSERT(offsetof(servo_id_tuning, cap) == 192, "place of cap");

#ifdef __cplusplus
extern "C" {
#endif

/* Settings with sample time (s) and counts per revolution after x4 quadrature, and nothing else. */
int32_t servo_id_settings_init(servo_id_settings *settings, uint32_t size, double sample_time,
                               double counts_per_revolution);
int32_t servo_id_settings_set(servo_id_settings *settings, int32_t parameter, double value);
int32_t servo_id_settings_set_range(servo_id_settings *settings, int32_t parameter, double low, double high);

/* Computes gamma of the gradient estimator for a reference that changes between -amplitude and +amplitude (rad). `hold` is
 * its shortest constant time, s, a whole number of samples. `samples` of it are simulated for the corners of the parameter
 * range. `coulomb` is not zero for an estimator with Coulomb friction. Needs a parameter range or an initial b, and gains. */
int32_t servo_id_settings_choose_gamma(servo_id_settings *settings, double amplitude, double hold, uint32_t samples,
                                       int32_t coulomb, servo_id_error *error);

/* Identifiers for use beside your own controller.
 *
 * _sample: once in each sample, with the counts that the encoder has moved since the last one, and the command that acts
 * from now on: the total, after every limit. The status is its event.
 * _learn: the same for a sensor that does not count, with the increment in units of SERVO_ID_RESOLUTION.
 * _resume: continues after a gap, at a speed in counts per sample; the estimates are kept.
 * _estimates: SERVO_ID_NO_FIT before the first fit, when they are not valid.
 * _work: for Gauss-Newton, computes at most this number of blocks of the first fit; call it in the background.
 * _scale: for fixed point, the command units of the last bit of a command: pass the command over this number.
 * _init_from_constants: from the `words` numbers that `servo-id export --firmware c` writes; only the code of a sample is
 *     linked. Gauss-Newton starts from the servo of the result and needs no _work.
 * _machine_estimates: the four estimates, without double precision; each times the number of the exported file is SI. */
int32_t servo_id_gradient_init(servo_id_gradient *object, uint32_t size, const servo_id_settings *settings,
                               servo_id_error *error);
int32_t servo_id_gradient_sample(servo_id_gradient *object, int32_t moved, float command);
int32_t servo_id_gradient_resume(servo_id_gradient *object, int32_t moved);
int32_t servo_id_gradient_estimates(const servo_id_gradient *object, servo_id_estimates *estimates);
int32_t servo_id_gradient_learn(servo_id_gradient *object, float increment, float command);
int32_t servo_id_gradient_init_from_constants(servo_id_gradient *object, uint32_t size, const uint32_t *constants,
                                              uint32_t words);
int32_t servo_id_gradient_machine_estimates(const servo_id_gradient *object, float *machine);

int32_t servo_id_gradient_coulomb_init(servo_id_gradient_coulomb *object, uint32_t size,
                                       const servo_id_settings *settings, servo_id_error *error);
int32_t servo_id_gradient_coulomb_sample(servo_id_gradient_coulomb *object, int32_t moved, float command);
int32_t servo_id_gradient_coulomb_resume(servo_id_gradient_coulomb *object, int32_t moved);
int32_t servo_id_gradient_coulomb_estimates(const servo_id_gradient_coulomb *object, servo_id_estimates *estimates);
int32_t servo_id_gradient_coulomb_learn(servo_id_gradient_coulomb *object, float increment, float command);
int32_t servo_id_gradient_coulomb_init_from_constants(servo_id_gradient_coulomb *object, uint32_t size,
                                                      const uint32_t *constants, uint32_t words);
int32_t servo_id_gradient_coulomb_machine_estimates(const servo_id_gradient_coulomb *object, float *machine);

int32_t servo_id_gauss_newton_init(servo_id_gauss_newton *object, uint32_t size, const servo_id_settings *settings,
                                   servo_id_error *error);
int32_t servo_id_gauss_newton_sample(servo_id_gauss_newton *object, int32_t moved, float command);
int32_t servo_id_gauss_newton_resume(servo_id_gauss_newton *object, int32_t moved);
int32_t servo_id_gauss_newton_estimates(const servo_id_gauss_newton *object, servo_id_estimates *estimates);
int32_t servo_id_gauss_newton_learn(servo_id_gauss_newton *object, float increment, float command);
int32_t servo_id_gauss_newton_work(servo_id_gauss_newton *object, uint32_t blocks);
int32_t servo_id_gauss_newton_init_from_constants(servo_id_gauss_newton *object, uint32_t size,
                                                  const uint32_t *constants, uint32_t words);
int32_t servo_id_gauss_newton_machine_estimates(const servo_id_gauss_newton *object, float *machine);

int32_t servo_id_fixed_init(servo_id_fixed *object, uint32_t size, const servo_id_settings *settings,
                            servo_id_error *error);
int32_t servo_id_fixed_sample(servo_id_fixed *object, int32_t moved, int32_t command);
int32_t servo_id_fixed_resume(servo_id_fixed *object, int32_t moved);
int32_t servo_id_fixed_estimates(const servo_id_fixed *object, servo_id_estimates *estimates);
int32_t servo_id_fixed_scale(const servo_id_fixed *object, double *scale);
int32_t servo_id_fixed_init_from_constants(servo_id_fixed *object, uint32_t size, const uint32_t *constants,
                                           uint32_t words);
int32_t servo_id_fixed_machine_estimates(const servo_id_fixed *object, int32_t *machine);

int32_t servo_id_fixed_coulomb_init(servo_id_fixed_coulomb *object, uint32_t size, const servo_id_settings *settings,
                                    servo_id_error *error);
int32_t servo_id_fixed_coulomb_sample(servo_id_fixed_coulomb *object, int32_t moved, int32_t command);
int32_t servo_id_fixed_coulomb_resume(servo_id_fixed_coulomb *object, int32_t moved);
int32_t servo_id_fixed_coulomb_estimates(const servo_id_fixed_coulomb *object, servo_id_estimates *estimates);
int32_t servo_id_fixed_coulomb_scale(const servo_id_fixed_coulomb *object, double *scale);
int32_t servo_id_fixed_coulomb_init_from_constants(servo_id_fixed_coulomb *object, uint32_t size,
                                                   const uint32_t *constants, uint32_t words);
int32_t servo_id_fixed_coulomb_machine_estimates(const servo_id_fixed_coulomb *object, int32_t *machine);

/* Loops: a PID with one of the identifiers.
 *
 * _init: at rest at a count.
 * _process: once in each sample, towards a setpoint in counts plus an offset (counts, in fixed point counts times 65536);
 * counts wrap at 32 bits. After an error the command is zero: disable the servo then.
 * _control, _learn: the two halves of a sample, to output the command first; _learn takes the command that acts. */
int32_t servo_id_gradient_loop_init(servo_id_gradient_loop *object, uint32_t size, const servo_id_settings *settings,
                                    int32_t count, servo_id_error *error);
int32_t servo_id_gradient_loop_process(servo_id_gradient_loop *object, int32_t setpoint, float offset, int32_t count,
                                       float *command);
int32_t servo_id_gradient_loop_control(servo_id_gradient_loop *object, int32_t setpoint, float offset, int32_t count,
                                       float *command);
int32_t servo_id_gradient_loop_learn(servo_id_gradient_loop *object, float acted);
int32_t servo_id_gradient_loop_estimates(const servo_id_gradient_loop *object, servo_id_estimates *estimates);
int32_t servo_id_gradient_loop_init_from_constants(servo_id_gradient_loop *object, uint32_t size,
                                                   const uint32_t *constants, uint32_t words, int32_t count);
int32_t servo_id_gradient_loop_machine_estimates(const servo_id_gradient_loop *object, float *machine);

int32_t servo_id_gradient_coulomb_loop_init(servo_id_gradient_coulomb_loop *object, uint32_t size,
                                            const servo_id_settings *settings, int32_t count, servo_id_error *error);
int32_t servo_id_gradient_coulomb_loop_process(servo_id_gradient_coulomb_loop *object, int32_t setpoint, float offset,
                                               int32_t count, float *command);
int32_t servo_id_gradient_coulomb_loop_control(servo_id_gradient_coulomb_loop *object, int32_t setpoint, float offset,
                                               int32_t count, float *command);
int32_t servo_id_gradient_coulomb_loop_learn(servo_id_gradient_coulomb_loop *object, float acted);
int32_t servo_id_gradient_coulomb_loop_estimates(const servo_id_gradient_coulomb_loop *object,
                                                 servo_id_estimates *estimates);
int32_t servo_id_gradient_coulomb_loop_init_from_constants(servo_id_gradient_coulomb_loop *object, uint32_t size,
                                                           const uint32_t *constants, uint32_t words, int32_t count);
int32_t servo_id_gradient_coulomb_loop_machine_estimates(const servo_id_gradient_coulomb_loop *object, float *machine);

int32_t servo_id_gauss_newton_loop_init(servo_id_gauss_newton_loop *object, uint32_t size,
                                        const servo_id_settings *settings, int32_t count, servo_id_error *error);
int32_t servo_id_gauss_newton_loop_process(servo_id_gauss_newton_loop *object, int32_t setpoint, float offset,
                                           int32_t count, float *command);
int32_t servo_id_gauss_newton_loop_control(servo_id_gauss_newton_loop *object, int32_t setpoint, float offset,
                                           int32_t count, float *command);
int32_t servo_id_gauss_newton_loop_learn(servo_id_gauss_newton_loop *object, float acted);
int32_t servo_id_gauss_newton_loop_estimates(const servo_id_gauss_newton_loop *object, servo_id_estimates *estimates);
int32_t servo_id_gauss_newton_loop_work(servo_id_gauss_newton_loop *object, uint32_t blocks);
int32_t servo_id_gauss_newton_loop_init_from_constants(servo_id_gauss_newton_loop *object, uint32_t size,
                                                       const uint32_t *constants, uint32_t words, int32_t count);
int32_t servo_id_gauss_newton_loop_machine_estimates(const servo_id_gauss_newton_loop *object, float *machine);

int32_t servo_id_fixed_loop_init(servo_id_fixed_loop *object, uint32_t size, const servo_id_settings *settings,
                                 int32_t count, servo_id_error *error);
int32_t servo_id_fixed_loop_process(servo_id_fixed_loop *object, int32_t setpoint, int32_t offset, int32_t count,
                                    int32_t *command);
int32_t servo_id_fixed_loop_control(servo_id_fixed_loop *object, int32_t setpoint, int32_t offset, int32_t count,
                                    int32_t *command);
int32_t servo_id_fixed_loop_learn(servo_id_fixed_loop *object, int32_t acted);
int32_t servo_id_fixed_loop_estimates(const servo_id_fixed_loop *object, servo_id_estimates *estimates);
int32_t servo_id_fixed_loop_scale(const servo_id_fixed_loop *object, double *scale);
int32_t servo_id_fixed_loop_init_from_constants(servo_id_fixed_loop *object, uint32_t size, const uint32_t *constants,
                                                uint32_t words, int32_t count);
int32_t servo_id_fixed_loop_machine_estimates(const servo_id_fixed_loop *object, int32_t *machine);

int32_t servo_id_fixed_coulomb_loop_init(servo_id_fixed_coulomb_loop *object, uint32_t size,
                                         const servo_id_settings *settings, int32_t count, servo_id_error *error);
int32_t servo_id_fixed_coulomb_loop_process(servo_id_fixed_coulomb_loop *object, int32_t setpoint, int32_t offset,
                                            int32_t count, int32_t *command);
int32_t servo_id_fixed_coulomb_loop_control(servo_id_fixed_coulomb_loop *object, int32_t setpoint, int32_t offset,
                                            int32_t count, int32_t *command);
int32_t servo_id_fixed_coulomb_loop_learn(servo_id_fixed_coulomb_loop *object, int32_t acted);
int32_t servo_id_fixed_coulomb_loop_estimates(const servo_id_fixed_coulomb_loop *object, servo_id_estimates *estimates);
int32_t servo_id_fixed_coulomb_loop_scale(const servo_id_fixed_coulomb_loop *object, double *scale);
int32_t servo_id_fixed_coulomb_loop_init_from_constants(servo_id_fixed_coulomb_loop *object, uint32_t size,
                                                        const uint32_t *constants, uint32_t words, int32_t count);
int32_t servo_id_fixed_coulomb_loop_machine_estimates(const servo_id_fixed_coulomb_loop *object, int32_t *machine);

/* The verdict in short on estimates with standard errors, for a usual command (command units) and speed (rad/s). Within
 * tolerance is b to 1.5 %, a to 5 % or 1 % of b command / speed, friction and load to 5 % or 0.5 % of b command. */
int32_t servo_id_judge(const servo_id_estimates *estimates, double command, double speed, servo_id_verdict *verdict);

/* The servo of estimates with standard errors, which are assumed to be independent. */
int32_t servo_id_servo_from_estimates(const servo_id_estimates *estimates, double delay, double unexplained,
                                      servo_id_servo *servo);

/* Gains for a servo. _work computes at most this number of slices and returns SERVO_ID_PENDING until it is done, after
 * fewer than 20000 slices. */
int32_t servo_id_tuner_init(servo_id_tuner *tuner, uint32_t size, const servo_id_settings *settings,
                            const servo_id_servo *servo, servo_id_error *error);
int32_t servo_id_tuner_work(servo_id_tuner *tuner, uint32_t slices, servo_id_tuning *tuning, servo_id_error *error);

/* Commissioning: moves an unknown servo within limits, identifies it, computes gains and tests them on it. After a failure
 * the old gains hold it again. Needs SERVO_ID_TRAVEL, SERVO_ID_SPEED, SERVO_ID_LIMIT and SERVO_ID_DURATION.
 *
 * The interrupt has the commission, the background the solver. In each sample call servo_id_commission_sample, and pass its
 * record, if there is one, to servo_id_solver_take. In the background call servo_id_solver_work. If its status is
 * SERVO_ID_DECIDED, pass its decision to servo_id_commission_accept. You may copy both through queues. `slices` is the number
 * of slices allowed, and afterwards the number left; servo_id_commission_slices is the number that fits into a sample.
 *
 * _init: at a count; disabled, or held by the PID of the settings with the command `held`.
 * _sample: `conditions` are SERVO_ID_NO_COUNT and SERVO_ID_LATE, `stop` is zero or the number of a reason to end it. It
 * holds the servo after its end too. */
int32_t servo_id_commission_init(servo_id_commission *commission, uint32_t size, const servo_id_settings *settings,
                                 int32_t count, float held, servo_id_error *error);
int32_t servo_id_commission_slices(const servo_id_commission *commission, uint32_t *slices);
int32_t servo_id_commission_sample(servo_id_commission *commission, int32_t count, int32_t conditions, int32_t stop,
                                   servo_id_commission_step *step);
int32_t servo_id_commission_accept(servo_id_commission *commission, const servo_id_decision *decision);
int32_t servo_id_commission_get_result(const servo_id_commission *commission, servo_id_commission_result *result);
int32_t servo_id_solver_init(servo_id_solver *solver, uint32_t size, const servo_id_settings *settings,
                             servo_id_error *error);
int32_t servo_id_solver_take(servo_id_solver *solver, const servo_id_record *record);
int32_t servo_id_solver_work(servo_id_solver *solver, uint32_t *slices, servo_id_decision *decision);

/* The cause of a reason: a text and its number of bytes, without a zero at its end. */
int32_t servo_id_reason_cause(int32_t reason, const char **text, uint32_t *length);

/* A sentence about a status, and the name of a parameter. */
int32_t servo_id_status_text(int32_t status, const char **text);
int32_t servo_id_parameter_name(int32_t parameter, const char **name);

#ifdef __cplusplus
}
#endif

#endif

/* servo_id.h: identify the friction, gain and load of a servo axis while a controller runs it, and tune its PID.
 *
 * The servo is q'' = -a q' + b u + d - c sign(q'), with the command u that acts, in SI (for a linear axis read m for
 * rad): a in 1/s, b in rad/s^2 per command unit, Coulomb friction c and load d in rad/s^2.
 *
 * Settings are a structure of named fields. Your program owns the memory of every object: declare one and initialise it.
 * The library has no heap, no global variable and no panic. An object may be copied byte by byte, and needs no
 * destruction.
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
enum servo_id_status {
    SERVO_ID_OK = 0,
    SERVO_ID_SLOWED = 1,
    SERVO_ID_STANDING = 2,
    SERVO_ID_RESTARTED = 3,
    SERVO_ID_STARTED = 4,
    SERVO_ID_LOAD_STEP = 5,
    SERVO_ID_TERM_ENTERED = 6,
    SERVO_ID_FRICTION_LOWERED = 7,
    SERVO_ID_AT_BOUND = 8,
    SERVO_ID_NOT_FOLLOWING = 9,
    SERVO_ID_FIRST_FIT_OVERDUE = 10,
    SERVO_ID_PENDING = 20,
    SERVO_ID_DECIDED = 21,
    SERVO_ID_NULL_POINTER = -1,
    SERVO_ID_MISALIGNED = -2,
    SERVO_ID_TOO_SMALL = -3,
    SERVO_ID_NOT_INITIALISED = -4,
    SERVO_ID_NO_SUCH_NUMBER = -5,
    SERVO_ID_OUT_OF_RANGE = -10,
    SERVO_ID_NOT_GIVEN = -11,
    SERVO_ID_GAMMA = -12,
    SERVO_ID_NO_MOTION = -13,
    SERVO_ID_CERTIFICATE = -14,
    SERVO_ID_LOOP_UNSTABLE = -15,
    SERVO_ID_ESTIMATE_UNSTABLE = -16,
    SERVO_ID_NOT_SUPPORTED = -17,
    SERVO_ID_ERROR_NOT_FINITE = -20,
    SERVO_ID_TOO_FAR_APART = -21,
    SERVO_ID_COUNT_JUMPED = -22,
    SERVO_ID_COMMAND_NOT_FINITE = -23,
    SERVO_ID_SAMPLE_REFUSED = -24,
    SERVO_ID_NO_SAMPLE = -25,
    SERVO_ID_NO_FIT = -30,
    SERVO_ID_NO_STANDARD_ERRORS = -31,
    SERVO_ID_TOO_FAST = -40,
    SERVO_ID_NOT_KNOWN = -41,
    SERVO_ID_DOES_NOT_ARRIVE = -42,
    SERVO_ID_CONSTANTS_VERSION = -50,
    SERVO_ID_CONSTANTS_TYPE = -51,
    SERVO_ID_CONSTANTS_CHANGED = -52,
};

/* Ranges that are allowed, with low and high of servo_id_error. */
enum servo_id_allowed {
    SERVO_ID_ALLOWED_UNKNOWN = 0,
    SERVO_ID_ALLOWED_FINITE = 1,
    SERVO_ID_ALLOWED_ABOVE = 2,
    SERVO_ID_ALLOWED_AT_LEAST = 3,
    SERVO_ID_ALLOWED_BELOW = 4,
    SERVO_ID_ALLOWED_AT_MOST = 5,
    SERVO_ID_ALLOWED_BETWEEN = 6,
    SERVO_ID_ALLOWED_WITHIN = 7,
    SERVO_ID_ALLOWED_POSITIVE_UP_TO = 8,
    SERVO_ID_ALLOWED_MULTIPLE_OF = 9,
};

/* Places of the parameters in arrays. */
enum servo_id_place {
    SERVO_ID_A = 0,
    SERVO_ID_B = 1,
    SERVO_ID_COULOMB = 2,
    SERVO_ID_LOAD = 3,
};

/* States of an estimate in a verdict. */
enum servo_id_state {
    SERVO_ID_KNOWN = 0,
    SERVO_ID_UNCERTAIN = 1,
    SERVO_ID_IS_AT_BOUND = 2,
};

/* What keeps a tuned loop from being faster. */
enum servo_id_cap {
    SERVO_ID_CAP_NONE = 0,
    SERVO_ID_CAP_DELAY = 1,
    SERVO_ID_CAP_ENCODER_NOISE = 2,
    SERVO_ID_CAP_COMMAND_LIMIT = 3,
    SERVO_ID_CAP_RESONANCE = 4,
    SERVO_ID_CAP_UNSEEN_RESONANCE = 5,
};

/* Phases of a commissioning; the last three are ends. */
enum servo_id_phase {
    SERVO_ID_PHASE_IDLE = 0,
    SERVO_ID_PHASE_REST = 1,
    SERVO_ID_PHASE_PROBE = 2,
    SERVO_ID_PHASE_FIT = 3,
    SERVO_ID_PHASE_FREQUENCY_RESPONSE = 4,
    SERVO_ID_PHASE_GAINS = 5,
    SERVO_ID_PHASE_TRIAL = 6,
    SERVO_ID_PHASE_APPLIED = 7,
    SERVO_ID_PHASE_ROLLED_BACK = 8,
    SERVO_ID_PHASE_ABORTED = 9,
};

/* Conditions of a sample of a commissioning, which are added. */
enum servo_id_condition {
    SERVO_ID_IN_ORDER = 0,
    SERVO_ID_NO_COUNT = 1, /* the encoder gave no valid reading */
    SERVO_ID_LATE = 2, /* the sample before ended too late */
};

/* No reason to end a commissioning. */
enum servo_id_stop {
    SERVO_ID_NO_STOP = 0,
};

/* A refusal. */
typedef struct servo_id_error {
    int32_t status;  /* enum servo_id_status */
    int32_t allowed; /* enum servo_id_allowed */
    double value;    /* that was refused */
    double low;      /* allowed; of SERVO_ID_ALLOWED_MULTIPLE_OF the step */
    double high;
    const char *parameter; /* the field of servo_id_settings, such as "servo_range.b"; NULL for none */
} servo_id_error;

/* Lowest and highest. */
typedef struct servo_id_range {
    double low;
    double high;
} servo_id_range;

/* A number for each parameter. */
typedef struct servo_id_parameters {
    double a;       /* 1/s */
    double b;       /* rad/s^2 per command unit */
    double coulomb; /* rad/s^2 */
    double load;    /* rad/s^2 */
} servo_id_parameters;

/* A range for each. */
typedef struct servo_id_bounds {
    servo_id_range a;
    servo_id_range b;
    servo_id_range coulomb;
    servo_id_range load;
} servo_id_bounds;

/* Gains in command form. */
typedef struct servo_id_gains {
    double kp; /* command units per rad */
    double kd; /* command units per rad/s */
    double ki; /* command units per rad s */
} servo_id_gains;

/* The range of the true servos. */
typedef struct servo_id_servo_range {
    servo_id_range a;
    servo_id_range b;
} servo_id_servo_range;

/* A feed-forward of the reference. */
typedef struct servo_id_feed_forward {
    double bandwidth;     /* of its reference model, rad/s; 0 for none */
    double acceleration;  /* 1/b, command units per rad/s^2 */
    double velocity;      /* a/b, command units per rad/s */
    double coulomb;       /* command units */
    double coulomb_speed; /* below it linear through zero, rad/s */
} servo_id_feed_forward;

/* The largest signals of fixed point. */
typedef struct servo_id_signal_ranges {
    double error;    /* of the position, rad */
    double velocity; /* rad/s */
    double command;  /* command units */
} servo_id_signal_ranges;

/* One for each parameter that is chosen. */
typedef struct servo_id_choice {
    int32_t a;
    int32_t b;
    int32_t coulomb;
    int32_t load;
} servo_id_choice;

/* Settings. A field that is zero is not stated and has its default. State them by their names:
 *
 *     servo_id_settings settings = {.sample_time = 1e-3, .counts_per_revolution = 4096, .kp = 9, .kd = 0.19};
 */
typedef struct servo_id_settings {
    double sample_time;           /* s; needed */
    double counts_per_revolution; /* of the encoder, with x4 quadrature; needed, or: */
    double resolution;            /* of a count, rad */
    double cutoff;                /* of the velocity estimate, rad/s; default half of the sample rate */

    /* The controller. */
    double kp;
    double kd;
    double ki;
    servo_id_range limit;    /* of the command, command units; default none */
    double reference_filter; /* time constant, s; default none */
    double notch;            /* filter of the command, rad/s; default none */
    servo_id_feed_forward feed_forward;

    /* The identifier. */
    servo_id_parameters initial;     /* first estimates */
    servo_id_bounds bounds;          /* of the estimates */
    servo_id_parameters uncertainty; /* standard deviations of the first estimates */
    servo_id_parameters gamma;       /* its diagonal, of the gradient estimator */
    servo_id_gains correction;       /* default those of the controller */
    servo_id_servo_range servo_range;    /* to be certified */
    double mu;                       /* 1/s */
    double bandwidth;                /* of the position loop, rad/s */
    double start_time;               /* of the first fit, s */
    double memory;                   /* s; default unlimited */
    double noise;                    /* standard deviation of the position, rad; default of a count */
    double max_speed;                /* rad/s */
    servo_id_signal_ranges ranges;   /* of fixed point */

    /* Tuning. */
    double command;         /* largest beyond that for the load; default infinite */
    double command_delay;   /* from the reading of the encoder to the output, s */
    double response_time;   /* goal: from 10 to 90 %, s */
    double loop_bandwidth;  /* goal: rad/s; without a goal as stiff as the servo allows */
    double max_sensitivity; /* default 1.6 */
    double max_noise;       /* part of the command; default 0.03 */
    double step;            /* of the predicted response, rad */
    double resonance;       /* lowest known, rad/s */

    /* Commissioning. */
    servo_id_range travel; /* about where the servo stands, rad */
    double speed;          /* largest, rad/s */
    double duration;       /* longest of a motion, s */
    double max_gain;       /* largest b that it may have, if that is known */
    double trial_step;     /* rad; default half of the travel */

    servo_id_choice known;     /* one for a parameter that stays at its first estimate */
    int32_t with_feed_forward; /* one: a tuning or a commissioning looks for a feed-forward too */
    int32_t unused;
} servo_id_settings;

/* Estimates of a, b, Coulomb friction and load. */
typedef struct servo_id_estimates {
    double value[4];     /* zero for a parameter that the model does not have */
    double std_error[4]; /* NaN if the estimator has none */
    int32_t at_bound[4]; /* one for an estimate at a bound, which is not valid */
} servo_id_estimates;

/* The verdict in short. */
typedef struct servo_id_verdict {
    int32_t known;    /* one if every estimate is known */
    int32_t state[4]; /* enum servo_id_state */
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
    servo_id_feed_forward feed_forward;
    double bandwidth; /* of the poles, rad/s */
    double step;      /* of the predicted response, rad */
    double rise_time[3]; /* from 10 to 90 %, s: from balanced friction; after a motion with the step; after one against it */
    double overshoot;    /* part of the step */
    double settling_time;  /* to 2 % of the step, s */
    double sensitivity;    /* the largest, for every servo within the errors */
    double gain_margin[2]; /* the loop's gain may fall and rise by these factors */
    double command_share;  /* largest command, as a part of the available */
    double noise;          /* in the command, standard deviation */
    double compliance;     /* rad per rad/s^2 of a step of the load */
    int32_t cap;           /* enum servo_id_cap */
    int32_t unused;
} servo_id_tuning;

/* Objects. */
#ifdef __cplusplus
#define SERVO_ID_ALIGNED alignas(8)
#define SERVO_ID_ASSERT static_assert
#else
#define SERVO_ID_ALIGNED _Alignas(8)
#define SERVO_ID_ASSERT _Static_assert
#endif

/* The paper's estimator of a and b; the load is carried by its correction */
typedef struct servo_id_gradient {
    SERVO_ID_ALIGNED uint64_t words[212];
} servo_id_gradient;

/* The same with Coulomb friction */
typedef struct servo_id_gradient_coulomb {
    SERVO_ID_ALIGNED uint64_t words[226];
} servo_id_gradient_coulomb;

/* Recursive Gauss-Newton for a, b, Coulomb friction and load */
typedef struct servo_id_gauss_newton {
    SERVO_ID_ALIGNED uint64_t words[680];
} servo_id_gauss_newton;

/* The paper's estimator of a and b in fixed point */
typedef struct servo_id_fixed {
    SERVO_ID_ALIGNED uint64_t words[224];
} servo_id_fixed;

/* The same with Coulomb friction */
typedef struct servo_id_fixed_coulomb {
    SERVO_ID_ALIGNED uint64_t words[240];
} servo_id_fixed_coulomb;

/* PID with the estimator of servo_id_gradient */
typedef struct servo_id_gradient_loop {
    SERVO_ID_ALIGNED uint64_t words[236];
} servo_id_gradient_loop;

/* PID with the estimator of servo_id_gradient_coulomb */
typedef struct servo_id_gradient_coulomb_loop {
    SERVO_ID_ALIGNED uint64_t words[250];
} servo_id_gradient_coulomb_loop;

/* PID with Gauss-Newton */
typedef struct servo_id_gauss_newton_loop {
    SERVO_ID_ALIGNED uint64_t words[690];
} servo_id_gauss_newton_loop;

/* PID and estimator in fixed point */
typedef struct servo_id_fixed_loop {
    SERVO_ID_ALIGNED uint64_t words[252];
} servo_id_fixed_loop;

/* The same with Coulomb friction */
typedef struct servo_id_fixed_coulomb_loop {
    SERVO_ID_ALIGNED uint64_t words[268];
} servo_id_fixed_coulomb_loop;

/* A search for gains */
typedef struct servo_id_tuner {
    SERVO_ID_ALIGNED uint64_t words[352];
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
    SERVO_ID_ALIGNED uint64_t words[6];
} servo_id_record;

/* From the background to the interrupt. */
typedef struct servo_id_decision {
    SERVO_ID_ALIGNED uint64_t words[80];
} servo_id_decision;

/* A sample of a commissioning. */
typedef struct servo_id_commission_step {
    float command;      /* that acts until the next sample; zero where the stage is to be disabled */
    int32_t is_enabled; /* one if the stage is to be enabled */
    int32_t phase;      /* enum servo_id_phase */
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

/* The library has the same sizes, and nothing between the fields; objects have room for its next versions. */
SERVO_ID_ASSERT(sizeof(servo_id_settings) == 552, "size of servo_id_settings");
SERVO_ID_ASSERT(sizeof(servo_id_commission_step) == 64, "size of servo_id_commission_step");
SERVO_ID_ASSERT(sizeof(servo_id_commission_result) == 480, "size of servo_id_commission_result");
SERVO_ID_ASSERT(sizeof(servo_id_error) == 40, "size of servo_id_error");
SERVO_ID_ASSERT(sizeof(servo_id_estimates) == 80, "size of servo_id_estimates");
SERVO_ID_ASSERT(sizeof(servo_id_verdict) == 20, "size of servo_id_verdict");
SERVO_ID_ASSERT(sizeof(servo_id_servo) == 248, "size of servo_id_servo");
SERVO_ID_ASSERT(sizeof(servo_id_tuning) == 200, "size of servo_id_tuning");

#ifdef __cplusplus
extern "C" {
#endif

/* Gives gamma of the gradient estimator for a reference that changes between -amplitude and +amplitude (rad), after `hold` s at
 * the soonest, which is a whole number of samples; `samples` of it are simulated for the corners of the parameter range. `coulomb` is
 * not zero for an estimator with Coulomb friction. Needs a parameter range or an initial b, and gains. */
int32_t servo_id_settings_choose_gamma(servo_id_settings *settings, double amplitude, double hold, uint32_t samples,
                                       int32_t coulomb, servo_id_error *error);

/* Identifiers for use beside your own controller.
 *
 * _sample: once in each sample, with the counts that the encoder has moved since the last one, and the command that acts
 * from now on: the total, after every limit. The status is its event.
 * _learn: the same for a sensor that does not count, with the increment in units of the resolution.
 * _resume: joins a motion after a gap, which moves by so many counts a sample; the estimates stay.
 * _estimates: SERVO_ID_NO_FIT before the first fit, when they are no result.
 * _work: the background's work; call it when there is time. Of Gauss-Newton the first fit, at most so many blocks of it. Of
 *     the gradient its memory, at least every 4 ms; without it the gradient is the paper's estimator alone, which is slow.
 * _scale: of fixed point the command units of the last bit of a command, which is a word: the command over this number.
 * _init_from_constants: from what `servo-id export --firmware c` writes, `words` numbers; nothing else of the library is
 *     linked than the samples. Gauss-Newton starts from the servo of the result and needs no _work.
 * _machine_estimates: the four estimates, without double precision; each times the number of the exported file is SI. */
int32_t servo_id_gradient_init(servo_id_gradient *object, uint32_t size, const servo_id_settings *settings,
                               servo_id_error *error);
int32_t servo_id_gradient_sample(servo_id_gradient *object, int32_t moved, float command);
int32_t servo_id_gradient_resume(servo_id_gradient *object, int32_t moved);
int32_t servo_id_gradient_estimates(const servo_id_gradient *object, servo_id_estimates *estimates);
int32_t servo_id_gradient_learn(servo_id_gradient *object, float increment, float command);
int32_t servo_id_gradient_work(servo_id_gradient *object, uint32_t blocks);
int32_t servo_id_gradient_init_from_constants(servo_id_gradient *object, uint32_t size, const uint32_t *constants,
                                              uint32_t words);
int32_t servo_id_gradient_machine_estimates(const servo_id_gradient *object, float *machine);

int32_t servo_id_gradient_coulomb_init(servo_id_gradient_coulomb *object, uint32_t size,
                                       const servo_id_settings *settings, servo_id_error *error);
int32_t servo_id_gradient_coulomb_sample(servo_id_gradient_coulomb *object, int32_t moved, float command);
int32_t servo_id_gradient_coulomb_resume(servo_id_gradient_coulomb *object, int32_t moved);
int32_t servo_id_gradient_coulomb_estimates(const servo_id_gradient_coulomb *object, servo_id_estimates *estimates);
int32_t servo_id_gradient_coulomb_learn(servo_id_gradient_coulomb *object, float increment, float command);
int32_t servo_id_gradient_coulomb_work(servo_id_gradient_coulomb *object, uint32_t blocks);
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
int32_t servo_id_fixed_work(servo_id_fixed *object, uint32_t blocks);
int32_t servo_id_fixed_init_from_constants(servo_id_fixed *object, uint32_t size, const uint32_t *constants,
                                           uint32_t words);
int32_t servo_id_fixed_machine_estimates(const servo_id_fixed *object, int32_t *machine);

int32_t servo_id_fixed_coulomb_init(servo_id_fixed_coulomb *object, uint32_t size, const servo_id_settings *settings,
                                    servo_id_error *error);
int32_t servo_id_fixed_coulomb_sample(servo_id_fixed_coulomb *object, int32_t moved, int32_t command);
int32_t servo_id_fixed_coulomb_resume(servo_id_fixed_coulomb *object, int32_t moved);
int32_t servo_id_fixed_coulomb_estimates(const servo_id_fixed_coulomb *object, servo_id_estimates *estimates);
int32_t servo_id_fixed_coulomb_scale(const servo_id_fixed_coulomb *object, double *scale);
int32_t servo_id_fixed_coulomb_work(servo_id_fixed_coulomb *object, uint32_t blocks);
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
int32_t servo_id_gradient_loop_work(servo_id_gradient_loop *object, uint32_t blocks);
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
int32_t servo_id_gradient_coulomb_loop_work(servo_id_gradient_coulomb_loop *object, uint32_t blocks);
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
int32_t servo_id_fixed_loop_work(servo_id_fixed_loop *object, uint32_t blocks);
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
int32_t servo_id_fixed_coulomb_loop_work(servo_id_fixed_coulomb_loop *object, uint32_t blocks);
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

/* Commissioning: moves an unknown servo within limits, identifies it, finds gains and proves them on it; without success
 * the gains before hold it again. Needs the settings travel, speed, limit and duration.
 *
 * The interrupt has the commission, the background the solver. In each sample call servo_id_commission_sample, and pass its
 * record, if there is one, to servo_id_solver_take. In the background call servo_id_solver_work. If its status is
 * SERVO_ID_DECIDED, pass its decision to servo_id_commission_accept. You may copy both through queues. `slices` is the number
 * of slices allowed, and afterwards the number left; servo_id_commission_slices is the number that fits into a sample.
 *
 * _init: at a count, disabled, or held by the PID of the settings with the command `held`.
 * _sample: `conditions` are SERVO_ID_NO_COUNT and SERVO_ID_LATE, `stop` is SERVO_ID_NO_STOP or the number of a reason to end it. It
 * holds the servo after its end too. Any other number ends it as a stop does, and is refused by its status. Of every sample that
 * is refused `step` disables the stage, with a command of zero. */
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

/* A sentence about a status. */
int32_t servo_id_status_text(int32_t status, const char **text);

#ifdef __cplusplus
}
#endif

#endif

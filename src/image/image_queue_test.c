/* SPDX-License-Identifier: MIT */
#include "image/image_queue.h"

#include "image/image_samples.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdatomic.h>
#include <unistd.h>

#include <cmocka.h>

/* ---- a host whose jobs wait until they may run, and which counts ---- */

enum { OPEN = 1 << 20, SAMPLE_WIDTH = 37, SAMPLE_HEIGHT = 23, SAMPLE_BYTES = SAMPLE_WIDTH * SAMPLE_HEIGHT * 4 };

static struct {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int permits;               /* jobs that may still run */
    int began, pictures;       /* jobs so far; blocks for the pixels of the samples */
    uint32_t most_at_once;     /* handed over */
    long long live, most_live; /* bytes */
    size_t fail_size;          /* blocks at least so large cannot be had; 0: all can */
    int lines;
    char line[512];
} host_state = {.mutex = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static void permit(int count) {
    pthread_mutex_lock(&host_state.mutex);
    host_state.permits = count;
    pthread_cond_broadcast(&host_state.changed);
    pthread_mutex_unlock(&host_state.mutex);
}

static int began(void) {
    pthread_mutex_lock(&host_state.mutex);
    int count = host_state.began;
    pthread_mutex_unlock(&host_state.mutex);
    return count;
}

static void host_parallel_for(void *user, uint32_t count, void (*run)(void *context, uint32_t index), void *context) {
    UNUSED(user);
    for (uint32_t i = 0; i < count; i++) {
        pthread_mutex_lock(&host_state.mutex);
        host_state.most_at_once = MAX(host_state.most_at_once, count);
        host_state.began++;
        pthread_cond_broadcast(&host_state.changed);
        while (host_state.permits == 0) pthread_cond_wait(&host_state.changed, &host_state.mutex);
        host_state.permits--;
        pthread_mutex_unlock(&host_state.mutex);
        run(context, i);
    }
}

static void *host_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(user);
    pthread_mutex_lock(&host_state.mutex);
    bool fails = host_state.fail_size && new_size >= host_state.fail_size;
    host_state.pictures += new_size == SAMPLE_BYTES;
    if (!fails) host_state.live += (long long)new_size - (long long)(old ? old_size : 0);
    host_state.most_live = MAX(host_state.most_live, host_state.live);
    pthread_mutex_unlock(&host_state.mutex);
    if (fails) return NULL;
    if (new_size) return realloc(old, new_size);
    free(old);
    return NULL;
}

static void host_log_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    pthread_mutex_lock(&host_state.mutex);
    host_state.lines++;
    snprintf(host_state.line, sizeof host_state.line, "%s", line);
    pthread_mutex_unlock(&host_state.mutex);
}

/* With jobs of the host's, or of the queue's own. */
static fnl_host make_host(bool jobs) {
    host_state.permits = OPEN;
    host_state.began = host_state.pictures = host_state.lines = 0;
    host_state.live = host_state.most_live = host_state.most_at_once = 0;
    host_state.fail_size = 0;
    return host_resolve(&(fnl_host){
        .reallocate = host_reallocate, .log = host_log_line, .parallel_for = jobs ? host_parallel_for : NULL});
}

/* Machines may have no thread left. */
static bool refuse_threads;
int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *argument) {
    static int (*real)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    if (refuse_threads) return EAGAIN;
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "pthread_create");
    return real(thread, attributes, run, argument);
}

/* Whoever destroys the queue joins its thread, which waits for a job that is held back. */
static bool join_opens;
int pthread_join(pthread_t thread, void **out) {
    static int (*real)(pthread_t, void **);
    if (join_opens) permit(OPEN);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "pthread_join");
    return real(thread, out);
}

/* ---- helpers ---- */

static struct image_sample samples[IMAGE_SAMPLES_MAX];
static uint32_t sample_count;

static struct image_request request_of(uint32_t id, const struct image_sample *sample) {
    return (struct image_request){
        id, sample->bytes, sample->size, sample->name, (uint64_t)sample->expected.width * sample->expected.height * 4, {.mips = true}};
}

static const struct image_sample *find_sample(enum image_file_kind kind) {
    for (uint32_t i = 0; i < sample_count; i++)
        if (samples[i].kind == kind && samples[i].result == FNL_OK) return &samples[i];
    fail_msg("no sample of kind %d", (int)kind);
    return NULL;
}

static struct image_answer await(struct image_queue *queue) {
    struct image_answer answer;
    while (!image_queue_take(queue, &answer)) usleep(1000);
    return answer;
}

static int make_samples(void **state) {
    UNUSED(state);
    sample_count = image_samples_make(samples, SAMPLE_WIDTH, SAMPLE_HEIGHT);
    return 0;
}

static int free_samples(void **state) {
    UNUSED(state);
    image_samples_free(samples, sample_count);
    return 0;
}

/* ---- tests ---- */

/* Every kind of file gives what decoding it at once gives, with the host's jobs and with those of the queue. */
static void test_answers_are_what_decoding_gives(void **state) {
    UNUSED(state);
    for (int jobs = 0; jobs < 2; jobs++) {
        fnl_host host = make_host(jobs);
        struct image_queue *queue;
        assert_int_equal(image_queue_create(&host, 3, &queue), FNL_OK);
        for (uint32_t i = 0; i < sample_count; i++) {
            const struct image_request request = request_of(i, &samples[i]);
            assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
        }
        bool seen[IMAGE_SAMPLES_MAX] = {false};
        for (uint32_t i = 0; i < sample_count; i++) {
            struct image_answer answer = await(queue);
            const struct image_sample *sample = &samples[answer.id];
            fnl_image expected;
            assert_true(answer.id < sample_count && !seen[answer.id]);
            seen[answer.id] = true;
            assert_int_equal(answer.result,
                             image_decode(&host, sample->bytes, sample->size, sample->name, true, &expected));
            if (answer.result != FNL_OK) continue;
            assert_int_equal(answer.texture.width, expected.width);
            assert_memory_equal(answer.texture.bytes, expected.pixels, (size_t)expected.width * expected.height * 4);
            texture_free(&host, &answer.texture);
            fnl_image_free(&host, &expected);
        }
        struct image_answer none;
        assert_false(image_queue_take(queue, &none));
        image_queue_destroy(&queue);
        assert_null(queue);
        assert_int_equal(host_state.began, jobs ? (int)sample_count : 0); /* each once */
        assert_int_equal(host_state.live, 0);
    }
}

/* Whoever asks and takes does not wait for what is held back. */
static void test_taking_never_waits(void **state) {
    UNUSED(state);
    const struct image_sample *png = find_sample(IMAGE_FILE_PNG);
    fnl_host host = make_host(true);
    struct image_queue *queue;
    struct image_answer answer;
    permit(0);
    assert_int_equal(image_queue_create(&host, 1, &queue), FNL_OK);
    for (uint32_t i = 0; i < 3; i++) {
        const struct image_request request = request_of(i, png);
        assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
    }
    while (began() == 0) usleep(1000);
    assert_false(image_queue_take(queue, &answer));
    permit(1);
    answer = await(queue);
    assert_int_equal(answer.id, 0);
    texture_free(&host, &answer.texture);
    assert_false(image_queue_take(queue, &answer));
    permit(OPEN);
    for (uint32_t i = 1; i < 3; i++) {
        answer = await(queue);
        assert_int_equal(answer.id, i);
        texture_free(&host, &answer.texture);
    }
    image_queue_destroy(&queue);
    assert_int_equal(host_state.live, 0);
}

static void test_a_broken_file_is_told_once(void **state) {
    UNUSED(state);
    fnl_host host = make_host(true);
    struct image_queue *queue;
    const struct image_request broken = {7, "no picture", 10, "car.glb: /images/2", 400, {.mips = true}};
    assert_int_equal(image_queue_create(&host, 1, &queue), FNL_OK);
    assert_int_equal(image_queue_ask(queue, &broken), FNL_OK);
    struct image_answer answer = await(queue);
    assert_int_equal(answer.id, 7);
    assert_int_equal(answer.result, FNL_ERROR_FORMAT);
    assert_null(answer.texture.bytes);
    assert_int_equal(host_state.lines, 1);
    assert_non_null(strstr(host_state.line, "car.glb: /images/2: "));
    image_queue_destroy(&queue);
    assert_int_equal(host_state.live, 0);
}

/* Memory may run out for the pixels, which the answer says, or for the request. */
static void test_memory_runs_out(void **state) {
    UNUSED(state);
    const struct image_sample *png = find_sample(IMAGE_FILE_PNG);
    fnl_host host = make_host(true);
    struct image_queue *queue;
    host_state.fail_size = 1;
    assert_int_equal(image_queue_create(&host, 1, &queue), FNL_ERROR_MEMORY);
    assert_null(queue);
    host_state.fail_size = 0;
    assert_int_equal(image_queue_create(&host, 1, &queue), FNL_OK);
    const struct image_request request = request_of(0, png);
    host_state.fail_size = 1;
    assert_int_equal(image_queue_ask(queue, &request), FNL_ERROR_MEMORY);
    host_state.fail_size = SAMPLE_BYTES;
    assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
    struct image_answer answer = await(queue);
    assert_int_equal(answer.result, FNL_ERROR_MEMORY);
    assert_null(answer.texture.bytes);
    pthread_mutex_lock(&host_state.mutex);
    host_state.fail_size = 0;
    pthread_mutex_unlock(&host_state.mutex);
    assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
    answer = await(queue);
    assert_int_equal(answer.result, FNL_OK);
    texture_free(&host, &answer.texture);
    image_queue_destroy(&queue);
    assert_int_equal(host_state.live, 0);
}

/* What was not begun is not decoded, and nothing of what was is left. */
static void test_destroyed_in_the_middle(void **state) {
    UNUSED(state);
    const struct image_sample *png = find_sample(IMAGE_FILE_PNG);
    for (int jobs = 0; jobs < 2; jobs++) {
        fnl_host host = make_host(jobs);
        struct image_queue *queue;
        assert_int_equal(image_queue_create(&host, 2, &queue), FNL_OK);
        permit(3);
        for (uint32_t i = 0; i < 200; i++) {
            const struct image_request request = request_of(i, png);
            assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
        }
        while (jobs && began() < 4) usleep(1000); /* three are decoded, one waits */
        join_opens = true;
        image_queue_destroy(&queue);
        join_opens = false;
        if (jobs) assert_int_equal(host_state.pictures, 3);
        assert_true(host_state.pictures < 200);
        assert_int_equal(host_state.live, 0);
    }
    struct image_queue *none = NULL;
    image_queue_destroy(&none);
}

/* With nobody to take them, pictures stop being decoded once 32 MiB wait; and large ones are begun one after the other. */
static void test_little_waits_to_be_taken(void **state) {
    UNUSED(state);
    enum { SIDE = 128, COUNT = 600, WAITING = (32 << 20) / (SIDE * SIDE * 4) };
    struct image_sample large[IMAGE_SAMPLES_MAX];
    uint32_t large_count = image_samples_make(large, SIDE, SIDE);
    const struct image_sample *jpeg = NULL;
    for (uint32_t i = 0; i < large_count; i++)
        if (large[i].kind == IMAGE_FILE_JPEG && large[i].result == FNL_OK && !jpeg) jpeg = &large[i];
    assert_non_null(jpeg);
    fnl_host host = make_host(true);
    struct image_queue *queue;
    assert_int_equal(image_queue_create(&host, 1, &queue), FNL_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        const struct image_request request = request_of(i, jpeg);
        assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
    }
    while (began() < WAITING) usleep(1000);
    usleep(50000);
    assert_in_range(began(), WAITING, WAITING + 15); /* the rest of a batch */
    assert_in_range(host_state.most_at_once, 2, 16);
    for (uint32_t i = 0; i < COUNT; i++) {
        struct image_answer answer = await(queue);
        assert_int_equal(answer.result, FNL_OK);
        texture_free(&host, &answer.texture);
    }
    assert_int_equal(began(), COUNT);
    assert_in_range(host_state.most_live, 32 << 20, 34 << 20);
    host_state.most_at_once = 0;
    for (uint32_t i = 0; i < 4; i++) {
        struct image_request request = request_of(i, jpeg);
        request.pixel_bytes = 40 << 20;
        assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
    }
    for (uint32_t i = 0; i < 4; i++) {
        struct image_answer answer = await(queue);
        texture_free(&host, &answer.texture);
    }
    assert_int_equal(host_state.most_at_once, 1);
    image_queue_destroy(&queue);
    assert_int_equal(host_state.live, 0);
    image_samples_free(large, large_count);
}

static void test_without_threads(void **state) {
    UNUSED(state);
    const struct image_sample *png = find_sample(IMAGE_FILE_PNG);
    fnl_host host = make_host(false);
    struct image_queue *queue;
    refuse_threads = true;
    fnl_result result = image_queue_create(&host, 4, &queue);
    refuse_threads = false;
    assert_int_equal(result, FNL_OK);
    for (uint32_t i = 0; i < 20; i++) {
        const struct image_request request = request_of(i, png);
        assert_int_equal(image_queue_ask(queue, &request), FNL_OK);
    }
    struct image_answer answer;
    for (uint32_t i = 0; i < 20; i++) {
        assert_true(image_queue_take(queue, &answer));
        assert_int_equal(answer.id, i);
        texture_free(&host, &answer.texture);
    }
    assert_false(image_queue_take(queue, &answer));
    image_queue_destroy(&queue);
    assert_int_equal(host_state.live, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_answers_are_what_decoding_gives),
        cmocka_unit_test(test_taking_never_waits),
        cmocka_unit_test(test_a_broken_file_is_told_once),
        cmocka_unit_test(test_memory_runs_out),
        cmocka_unit_test(test_destroyed_in_the_middle),
        cmocka_unit_test(test_little_waits_to_be_taken),
        cmocka_unit_test(test_without_threads),
    };
    return cmocka_run_group_tests_name("image queue", tests, make_samples, free_samples);
}

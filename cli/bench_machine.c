/* SPDX-License-Identifier: MIT */
/* The machine that measures, and what else it does meanwhile. */
#include "bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

/* The value of the first line of /proc/cpuinfo that begins so; "" where there is none. */
static void processor_name(char *text, size_t capacity) {
    static const char *const keys[] = {"model name", "Hardware", "cpu model"};
    char line[512];
    FILE *file = fopen("/proc/cpuinfo", "r");
    *text = 0;
    while (file && !*text && fgets(line, sizeof line, file)) {
        const char *value = strchr(line, ':');
        for (size_t i = 0; value && i < sizeof keys / sizeof *keys; i++)
            if (strncmp(line, keys[i], strlen(keys[i])) == 0) snprintf(text, capacity, "%.*s", (int)strcspn(value + 2, "\n"), value + 2);
    }
    if (file) fclose(file);
}

json_t *bench_machine(void) {
    struct utsname system;
    char processor[256], kernel[512] = "";
    double load[1];
    processor_name(processor, sizeof processor);
    if (uname(&system) == 0) {
        snprintf(kernel, sizeof kernel, "%s %s", system.sysname, system.release);
        if (!*processor) snprintf(processor, sizeof processor, "%s", system.machine);
    }
    return json_pack("{s:s,s:i,s:s,s:o}", "processor", processor, "cores", (int)sysconf(_SC_NPROCESSORS_ONLN), "kernel", kernel, "load_before",
                     getloadavg(load, 1) == 1 ? json_real(load[0]) : json_null());
}

static double seconds_of(struct timeval t) { return (double)t.tv_sec + (double)t.tv_usec * 1e-6; }

struct bench_busy bench_busy_now(void) {
    struct bench_busy busy = {.all = NAN};
    struct timespec now;
    struct rusage own;
    unsigned long long user, nice, system, idle, wait, irq, soft;
    FILE *file = fopen("/proc/stat", "r");
    if (file && fscanf(file, "cpu %llu %llu %llu %llu %llu %llu %llu", &user, &nice, &system, &idle, &wait, &irq, &soft) == 7)
        busy.all = (double)(user + nice + system + irq + soft) / (double)sysconf(_SC_CLK_TCK);
    if (file) fclose(file);
    clock_gettime(CLOCK_MONOTONIC, &now);
    busy.at = (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
    if (getrusage(RUSAGE_SELF, &own) == 0) busy.own = seconds_of(own.ru_utime) + seconds_of(own.ru_stime);
    return busy;
}

double bench_others(const struct bench_busy *from, const struct bench_busy *to) {
    const double time = to->at - from->at;
    if (!(time > 0) || !isfinite(to->all - from->all)) return 0;
    return fmax((to->all - from->all - (to->own - from->own)) / time, 0);
}

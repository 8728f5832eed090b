/* SPDX-License-Identifier: MIT */
/** The files of bench_page/ and the charting library as the build embeds them; `chart` is empty where it was not found. */
#ifndef FNL_CLI_BENCH_PAGE_PARTS_H
#define FNL_CLI_BENCH_PAGE_PARTS_H

#include <stddef.h>

extern const char bench_page_html[], bench_page_css[], bench_page_js[], bench_page_chart[];
extern const size_t bench_page_html_size, bench_page_css_size, bench_page_js_size, bench_page_chart_size;

#endif

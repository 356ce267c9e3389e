#include "tools/charts/embedded_files.h"

#include <cstddef>

// The symbols that embedded_files.S has around each file. Only their addresses mean something.
extern "C" {
extern const char metabuffer_vega_bundle_begin[];
extern const char metabuffer_vega_bundle_end[];
extern const char metabuffer_charts_js_begin[];
extern const char metabuffer_charts_js_end[];
extern const char metabuffer_page_js_begin[];
extern const char metabuffer_page_js_end[];
extern const char metabuffer_page_css_begin[];
extern const char metabuffer_page_css_end[];
extern const char metabuffer_page_html_begin[];
extern const char metabuffer_page_html_end[];
extern const char metabuffer_elements_js_begin[];
extern const char metabuffer_elements_js_end[];
extern const char metabuffer_run_page_html_begin[];
extern const char metabuffer_run_page_html_end[];
extern const char metabuffer_run_page_css_begin[];
extern const char metabuffer_run_page_css_end[];
extern const char metabuffer_run_data_js_begin[];
extern const char metabuffer_run_data_js_end[];
extern const char metabuffer_run_wall_js_begin[];
extern const char metabuffer_run_wall_js_end[];
extern const char metabuffer_run_time_js_begin[];
extern const char metabuffer_run_time_js_end[];
extern const char metabuffer_run_page_js_begin[];
extern const char metabuffer_run_page_js_end[];
extern const char metabuffer_plot_js_begin[];
extern const char metabuffer_plot_js_end[];
}

namespace metabuffer::charts::embedded {

namespace {

std::string_view between(const char* begin, const char* end) {
    return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::string_view vega_bundle() { return between(metabuffer_vega_bundle_begin, metabuffer_vega_bundle_end); }
std::string_view charts_js() { return between(metabuffer_charts_js_begin, metabuffer_charts_js_end); }
std::string_view page_js() { return between(metabuffer_page_js_begin, metabuffer_page_js_end); }
std::string_view page_css() { return between(metabuffer_page_css_begin, metabuffer_page_css_end); }
std::string_view page_html() { return between(metabuffer_page_html_begin, metabuffer_page_html_end); }
std::string_view elements_js() { return between(metabuffer_elements_js_begin, metabuffer_elements_js_end); }
std::string_view run_page_html() {
    return between(metabuffer_run_page_html_begin, metabuffer_run_page_html_end);
}
std::string_view run_page_css() {
    return between(metabuffer_run_page_css_begin, metabuffer_run_page_css_end);
}
std::string_view run_data_js() { return between(metabuffer_run_data_js_begin, metabuffer_run_data_js_end); }
std::string_view run_wall_js() { return between(metabuffer_run_wall_js_begin, metabuffer_run_wall_js_end); }
std::string_view run_time_js() { return between(metabuffer_run_time_js_begin, metabuffer_run_time_js_end); }
std::string_view run_page_js() { return between(metabuffer_run_page_js_begin, metabuffer_run_page_js_end); }
std::string_view plot_js() { return between(metabuffer_plot_js_begin, metabuffer_plot_js_end); }

}  // namespace metabuffer::charts::embedded

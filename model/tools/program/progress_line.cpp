#include "tools/program/progress_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace metabuffer {

ProgressLine::ProgressLine(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
    if (shown_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(const std::string& text) const {
    if (shown_) std::fprintf(stderr, "\r%s\033[K", text.c_str());
}

void ProgressLine::show_run(std::int64_t core_cycles, double share) const {
    show(fmt::format("{} core clocks, {:3.0f} % of the pixels composited", core_cycles, 100.0 * share));
}

}  // namespace metabuffer

#include "tools/program/progress_line.h"

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

}  // namespace metabuffer

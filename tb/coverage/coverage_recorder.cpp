#include "coverage_recorder.h"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "coverage_file.h"
#include "machine_coverage.h"

namespace metabuffer::coverage {
namespace {

/// The command that started this process, without the program's folder: CTest runs each test in a process of its own,
/// so its arguments name the test.
std::string test_name() {
    std::ifstream in("/proc/self/cmdline", std::ios::binary);
    std::string text(std::istreambuf_iterator<char>(in), {});
    const std::size_t program_end = std::min(text.find('\0'), text.size());
    const std::size_t slash = text.rfind('/', program_end);
    if (slash != std::string::npos) text.erase(0, slash + 1);
    while (!text.empty() && text.back() == '\0') text.pop_back();
    for (char& letter : text) {
        if (letter == '\0' || letter == '\n') letter = ' ';
    }
    return text;
}

}  // namespace

void declare_machine_goals(Coverage& coverage) { const MachineGoals declared(coverage); }

CoverageRecorder::CoverageRecorder(rtl::Metabuffer& machine, const Scenario& scenario) {
    const char* directory = std::getenv("METABUFFER_COVERAGE");
    if (directory == nullptr || *directory == '\0') return;
    directory_ = directory;
    const std::string name = std::string(machine.name()) + "_coverage";
    machine_coverage_ = std::make_unique<MachineCoverage>(name.c_str(), machine, scenario);
}

void CoverageRecorder::finished(const RunReport& report) {
    if (machine_coverage_) machine_coverage_->finished(report);
}

CoverageRecorder::~CoverageRecorder() {
    if (!machine_coverage_) return;
    try {
        append_record(directory_ / (std::to_string(getpid()) + ".coverage"),
                      record_of(test_name(), machine_coverage_->counts()));
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';  // what is missing shows as a hole
    }
}

}  // namespace metabuffer::coverage

#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <systemc>

namespace metabuffer::test {

/// The one switch that makes any testbench write its waveform: with METABUFFER_TRACE=DIR in the environment,
/// the test case writes DIR/<its name>.vcd; without, this does nothing.
///
///     TraceSwitch trace;
///     trace.add(composer);  // anything that has trace(sc_trace_file*)
///     trace.add(busready, "busready");
///     sc_core::sc_start(...);
class TraceSwitch {
  public:
    TraceSwitch() {
        const char* directory = std::getenv("METABUFFER_TRACE");
        if (directory == nullptr || *directory == '\0') {
            return;
        }
        std::string name = Catch::getResultCapture().getCurrentTestName();
        std::replace_if(
            name.begin(), name.end(),
            [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)) == 0; }, '_');
        std::filesystem::create_directories(directory);
        file_ = sc_core::sc_create_vcd_trace_file((std::filesystem::path(directory) / name).c_str());
        file_->set_time_unit(1.0, sc_core::SC_PS);
    }
    TraceSwitch(const TraceSwitch&) = delete;
    TraceSwitch& operator=(const TraceSwitch&) = delete;
    ~TraceSwitch() {
        if (file_ != nullptr) {
            sc_core::sc_close_vcd_trace_file(file_);
        }
    }

    /// A block, by its own trace().
    template <typename Block>
    void add(const Block& block) {
        if (file_ != nullptr) {
            block.trace(file_);
        }
    }
    /// A signal of the testbench.
    template <typename Signal>
    void add(const Signal& signal, const std::string& name) {
        if (file_ != nullptr) {
            using sc_core::sc_trace;
            sc_trace(file_, signal, name);
        }
    }

  private:
    sc_core::sc_trace_file* file_ = nullptr;
};

}  // namespace metabuffer::test

#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <systemc>
#include <type_traits>
#include <vector>

#include "lockstep/lockstep.h"

namespace metabuffer::test {

/// A block whose reference is written down, clock by clock from the first one after reset, as strings: `_` and `-` are a
/// wire that is low or high, other values are letters, and `.` is a structure's default.
///
///     LockstepBench bench;
///     WaveformCase<rtl::PipelineHandshake> dut(bench, "handshake", ...);  // as a Lockstep
///     dut.drive("__-__", &rtl::PipelineHandshake::startframe_i);
///     dut.check("___-_", &rtl::PipelineHandshake::startframe_o);
///     dut.run();
///
/// Both are what the edge samples: what is written at edge n stands one letter behind what edge n has sampled. `?` is an
/// output that is not checked. All strings of a case are equally long.
template <typename Dut>
class WaveformCase final : public Lockstep<Dut> {
  public:
    template <typename Value>
    using Letters = std::map<char, Value>;

    using Lockstep<Dut>::Lockstep;

    template <typename Port>
    void drive(const std::string& wave, Port Dut::*port,
               const Letters<typename Port::data_type>& letters = {}) {
        drive_pin(this->in(port), wave, letters);
    }
    template <typename Port>
    void check(const std::string& wave, Port Dut::*port,
               const Letters<typename Port::data_type>& letters = {}) {
        check_pin(this->out(port), wave, letters);
    }
    template <typename Ports, typename Value = typename Ports::element_type::data_type>
    void drive(const std::string& wave, Ports Dut::*ports, std::size_t index,
               const Letters<Value>& letters = {}) {
        drive_pin(this->in(ports, index), wave, letters);
    }
    template <typename Ports, typename Value = typename Ports::element_type::data_type>
    void check(const std::string& wave, Ports Dut::*ports, std::size_t index,
               const Letters<Value>& letters = {}) {
        check_pin(this->out(ports, index), wave, letters);
    }
    /// Pins of which the case may have no string. An input then stands, an output is not checked.
    template <typename... Ports>
    void leave(Ports... ports) {
        (leave_pin(ports), ...);
    }
    /// To the end of the strings.
    void run() { this->bench_.run(static_cast<int>(clocks_)); }

  private:
    template <typename Port>
    void leave_pin(Port Dut::*port) {
        if (static_cast<sc_core::sc_port_base&>(this->dut().*port).bind_count() > 0) return;
        if constexpr (std::is_convertible_v<Port&, sc_core::sc_in<typename Port::data_type>&>) {
            this->in(port);
        } else {
            this->out(port);
        }
    }
    using Clocked = std::vector<std::function<void(std::size_t clock)>>;

    template <typename Value>
    std::vector<Value> values_of(const std::string& wave, Letters<Value> letters) {
        if (clocks_ != 0 && wave.size() != clocks_) throw std::invalid_argument("another length: " + wave);
        clocks_ = wave.size();
        if constexpr (std::is_same_v<Value, bool>) {
            letters.insert({{'_', false}, {'-', true}});
        } else {
            letters.insert({'.', Value{}});
        }
        letters.insert({'?', Value{}});
        std::vector<Value> values;
        for (const char letter : wave) values.push_back(letters.at(letter));
        return values;
    }
    template <typename Value>
    void drive_pin(Input<Value>& pin, const std::string& wave, const Letters<Value>& letters) {
        drives_.push_back(
            [&pin, values = values_of(wave, letters)](std::size_t clock) { pin = values.at(clock); });
    }
    template <typename Value>
    void check_pin(Output<Value>& pin, const std::string& wave, const Letters<Value>& letters) {
        checks_.push_back([&pin, wave, values = values_of(wave, letters)](std::size_t clock) {
            pin = values.at(clock);
            if (wave[clock] == '?') pin.ignore();
        });
    }
    void call(const Clocked& functions) const {
        const int clock = this->bench_.clock();
        if (clock < 0 || clock >= static_cast<int>(clocks_)) return;
        for (const auto& function : functions) function(static_cast<std::size_t>(clock));
    }
    void stimulate() override { call(drives_); }
    void expect() override { call(checks_); }

    std::size_t clocks_ = 0;
    Clocked drives_, checks_;
};

}  // namespace metabuffer::test

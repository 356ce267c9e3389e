#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <systemc>
#include <type_traits>
#include <utility>
#include <vector>

#include "rtl/fields.h"

namespace metabuffer::rtl {

/// How many bits a number from 0 to `maximum`, which is not negative, takes; at least 1.
constexpr int bits_for(std::int64_t maximum) {
    int bits = 1;
    while ((maximum >> bits) != 0) {
        ++bits;
    }
    return bits;
}

/// A part of a block that has no clock, with state of its own: `visit_state(see)` calls see(name, value, largest value)
/// for each of its registers, and see(name, value, largest, smallest) for those that may be negative.
template <typename Value, typename = void>
struct HasState : std::false_type {};
struct StateVisitor {
    template <typename Number>
    void operator()(const char* /*name*/, const Number& /*value*/, std::int64_t /*largest*/,
                    std::int64_t /*smallest*/ = 0) const {}
};
template <typename Value>
struct HasState<Value, std::void_t<decltype(std::declval<const Value&>().visit_state(StateVisitor{}))>>
    : std::true_type {};

/// A part that keeps something in reset has a reset() of its own.
template <typename Value, typename = void>
struct ResetsItself : std::false_type {};
template <typename Value>
struct ResetsItself<Value, std::void_t<decltype(std::declval<Value&>().reset())>> : std::true_type {};

/// A structure whose sc_trace() takes a width that depends on the signal: bits of an address, lanes of a beat.
template <typename Value, typename = void>
struct TakesWidth : std::false_type {};
template <typename Value>
struct TakesWidth<Value, std::void_t<decltype(sc_trace(static_cast<sc_core::sc_trace_file*>(nullptr),
                                                       std::declval<const Value&>(), std::string(), 1))>>
    : std::true_type {};

/// Adds a part's registers to a waveform, as PREFIX and their names.
struct StateTracer {
    sc_core::sc_trace_file* file;
    std::string prefix;

    template <typename Number>
    void operator()(const char* name, const Number& value, std::int64_t largest,
                    std::int64_t smallest = 0) const {
        trace_number(file, value, prefix + name, bits_for(largest) + (smallest < 0 ? 1 : 0), smallest < 0);
    }
};

/// What a RegisterSet knows of one of its registers. It lies elsewhere in memory than the value, so that a block's values,
/// which each edge needs, lie together.
class AnyRegister {
  public:
    AnyRegister() = default;
    AnyRegister(const AnyRegister&) = delete;
    AnyRegister& operator=(const AnyRegister&) = delete;
    virtual ~AnyRegister() = default;
    virtual void reset() = 0;
    virtual void trace(sc_core::sc_trace_file* file, const std::string& prefix) const = 0;
};

/// The registers of a block. Each adds itself where it is declared, so that reset and waveform leave none out. The set
/// knows at which edges one of them changes.
class RegisterSet {
  public:
    RegisterSet() = default;
    RegisterSet(const RegisterSet&) = delete;
    RegisterSet& operator=(const RegisterSet&) = delete;
    /// A part of another set, which has a waveform of its own. reset() and trace() of the whole leave it out.
    explicit RegisterSet(RegisterSet& whole) : changed_(whole.changed_) {}

    /// Gives every register its reset value, as at power-up.
    void reset() {
        for (const auto& each : registers_) {
            each->reset();
        }
        note_change();
    }
    /// One of the registers changes, or state that goes with them.
    void note_change() { *changed_ = true; }
    /// For what is combinational, on a clock that calls nobody: notified after each edge at which a register has changed.
    const sc_core::sc_event& changed_event() {
        if (changed_event_ == nullptr) changed_event_ = std::make_unique<sc_core::sc_event>();
        return *changed_event_;
    }
    /// Call it at the end of each edge. True if a register has changed.
    bool end_edge() { return std::exchange(own_changed_, false); }
    /// Then notifies changed_event().
    void notify_changed() {
        if (changed_event_ != nullptr) changed_event_->notify(sc_core::SC_ZERO_TIME);
    }
    /// prefix: the block's name and a dot.
    void trace(sc_core::sc_trace_file* file, const std::string& prefix) const {
        for (const auto& each : registers_) {
            each->trace(file, prefix);
        }
    }

  private:
    template <typename Value>
    friend class Register;
    bool own_changed_ = false;
    bool* changed_ = &own_changed_;
    std::vector<std::unique_ptr<AnyRegister>> registers_;
    std::unique_ptr<sc_core::sc_event> changed_event_;  ///< null if nobody waits for it
};

template <typename Value, typename = void>
struct CanBeCompared : std::false_type {};
template <typename Value>
struct CanBeCompared<Value,
                     std::void_t<decltype(std::declval<const Value&>() == std::declval<const Value&>())>>
    : std::true_type {};

/// A register: its name in the waveform, its width and its reset value. Only the block's clocked method writes it. The
/// method reads what it has written at once, as with a variable of a clocked process.
template <typename Value>
class Register final {
  public:
    /// width_bits: of a number or an enumeration; a flag has 1, and a structure traces its members itself, with this
    /// width if its sc_trace() takes one. A number has no sign in the waveform, unless its reset value is negative.
    /// What has visit_state() gives its own widths. Its names follow this one after an underscore, if this one is not
    /// empty.
    Register(RegisterSet& set, std::string name, int width_bits = 1, Value reset_value = Value{})
        : value_(reset_value), set_changed_(set.changed_) {
        set.registers_.push_back(
            std::make_unique<Description>(value_, std::move(name), width_bits, std::move(reset_value)));
    }
    Register(const Register&) = delete;

    operator const Value&() const { return value_; }
    const Value& value() const { return value_; }
    Register& operator=(const Value& value) {
        if constexpr (CanBeCompared<Value>::value) {
            if (value_ == value) return *this;
        }
        value_ = value;
        note_change();
        return *this;
    }
    Register& operator=(const Register& other) {
        if (this != &other) *this = other.value_;
        return *this;
    }
    Register& operator+=(const Value& by) { return *this = static_cast<Value>(value_ + by); }
    Register& operator-=(const Value& by) { return *this = static_cast<Value>(value_ - by); }
    const Value* operator->() const { return &value_; }
    /// The value, which is about to change.
    Value& change() {
        note_change();
        return value_;
    }
    Register& operator++() { return *this += 1; }
    Register& operator--() { return *this -= 1; }

  private:
    class Description;
    void note_change() { *set_changed_ = true; }

    Value value_;
    bool* set_changed_;
};

template <typename Value>
class Register<Value>::Description final : public AnyRegister {
  public:
    Description(Value& value, std::string name, int width_bits, Value reset_value)
        : value_(value),
          name_(std::move(name)),
          width_bits_(width_bits),
          reset_value_(std::move(reset_value)) {}

    void reset() override {
        if constexpr (ResetsItself<Value>::value) {
            value_.reset();
        } else {
            value_ = reset_value_;
        }
    }
    void trace(sc_core::sc_trace_file* file, const std::string& prefix) const override {
        const std::string name = prefix + name_;
        if constexpr (HasState<Value>::value) {
            value_.visit_state(StateTracer{file, name_.empty() ? name : name + '_'});
        } else if constexpr (std::is_integral_v<Value> || std::is_enum_v<Value>) {
            trace_number(file, value_, name, width_bits_, reset_value_ < Value{});
        } else if constexpr (TakesWidth<Value>::value) {
            sc_trace(file, value_, name, width_bits_);
        } else {
            sc_trace(file, value_, name);
        }
    }

  private:
    Value& value_;
    std::string name_;
    int width_bits_;
    Value reset_value_;
};

/// A registered output: its register and its port get the value if it is another one, since a write takes time.
template <typename Value, typename Port>
void drive_output(Register<Value>& output, Port& port, const Value& value) {
    if (!(value == output.value())) {
        output.change() = value;
        port.write(value);
    }
}

/// Registers that a value passes through, one per clock. With none it passes at once.
template <typename Value>
class RegisterLine {
  public:
    /// stages: 0 or more, named prefix_1, where a value comes in, and so on. width_bits: as of a Register.
    RegisterLine(RegisterSet& set, const std::string& prefix, int stages, int width_bits = 1) {
        for (int stage = 1; stage <= stages; ++stage) {
            stages_.push_back(
                std::make_unique<Register<Value>>(set, prefix + '_' + std::to_string(stage), width_bits));
        }
    }

    /// Call it once at each edge. Returns what leaves: it came in as many edges ago as there are stages.
    Value shift(const Value& input) {
        if (stages_.empty()) {
            return input;
        }
        Value leaves = last();
        for (std::size_t stage = stages_.size(); stage-- > 1;) {
            *stages_[stage] = *stages_[stage - 1];
        }
        *stages_.front() = input;
        return leaves;
    }
    /// The value in the last stage, which leaves next. There must be a stage.
    const Value& last() const { return stages_.back()->value(); }
    /// The value in a stage, counted from 1, where a value comes in.
    const Value& stage(int stage) const { return stages_[static_cast<std::size_t>(stage) - 1]->value(); }
    bool empty() const { return stages_.empty(); }
    /// Every stage has this value.
    bool holds(const Value& value) const {
        return std::all_of(stages_.begin(), stages_.end(),
                           [&value](const auto& stage) { return stage->value() == value; });
    }
    void fill(const Value& value) {
        for (const auto& stage : stages_) {
            *stage = value;
        }
    }

  private:
    std::vector<std::unique_ptr<Register<Value>>> stages_;
};

}  // namespace metabuffer::rtl

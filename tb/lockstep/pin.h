#pragma once

#include <deque>
#include <memory>
#include <sstream>
#include <string>
#include <systemc>
#include <type_traits>
#include <utility>
#include <vector>

#include "rtl/wire.h"

namespace metabuffer::test {

/// A pin of the blocks of a Lockstep, which the gated and the ungated one have alike.
class LockstepPin {
  public:
    static constexpr std::size_t kEdgesShown = 20;

    explicit LockstepPin(std::string name) : name_(std::move(name)) {}
    LockstepPin(const LockstepPin&) = delete;
    LockstepPin& operator=(const LockstepPin&) = delete;
    virtual ~LockstepPin() = default;

    const std::string& name() const { return name_; }
    /// Drives an input with its value.
    virtual void drive() {}
    /// Notes what the edge samples. Returns whether it is what is due.
    virtual bool sample() = 0;
    /// A line, or several: the last edges, and below an output that is wrong what was due.
    virtual std::string picture() const = 0;

    /// A wire as `__--`, what has more values as the edges at which it changes.
    template <typename Value>
    static std::string edges(const std::deque<Value>& values) {
        std::ostringstream text;
        if constexpr (std::is_same_v<Value, bool>) {
            for (const bool value : values) text << (value ? '-' : '_');
        } else {
            const Value* before = nullptr;
            for (std::size_t i = 0; i < values.size(); ++i) {
                if (before == nullptr || !(*before == values[i])) {
                    text << (before == nullptr ? "" : "  ") << '[' << i << "] " << values[i];
                }
                before = &values[i];
            }
        }
        return text.str();
    }

  protected:
    template <typename Value>
    static void keep(std::deque<Value>& values, const Value& value) {
        values.push_back(value);
        if (values.size() > kEdgesShown) values.pop_front();
    }

  private:
    std::string name_;
};

/// A pin with a value that the test assigns.
template <typename Value>
class ValuePin : public LockstepPin {
  public:
    using LockstepPin::LockstepPin;

    operator const Value&() const { return value_; }
    const Value& value() const { return value_; }
    const Value* operator->() const { return &value_; }

  protected:
    Value value_{};
};

/// An input: assign what the next edge is to sample. It stands until it is assigned again.
template <typename Value>
class Input final : public ValuePin<Value> {
  public:
    using ValuePin<Value>::ValuePin;

    Input& operator=(const Value& value) {
        this->value_ = value;
        return *this;
    }

    void bind(sc_core::sc_in<Value>& port) { port(signal_); }
    void drive() override {
        signal_.write(Value{});  // of what a Wire is given between two edges, the last counts
        signal_.write(this->value_);
    }
    bool sample() override {
        this->keep(values_, this->value_);
        return true;
    }
    std::string picture() const override { return this->edges(values_); }

  private:
    rtl::Wire<Value> signal_;
    std::deque<Value> values_;
};

/// An output: assign what is due there as the next edge samples it.
template <typename Value>
class Output final : public ValuePin<Value> {
  public:
    using ValuePin<Value>::ValuePin;

    Output& operator=(const Value& value) {
        this->value_ = value;
        checked_ = true;
        return *this;
    }
    /// The next edge may sample any value.
    void ignore() { checked_ = false; }
    /// What the last edge has sampled, where the reference leaves the block a choice.
    const Value& seen() const { return seen_.front().back(); }

    void bind(sc_core::sc_out<Value>& port) {
        signals_.push_back(std::make_unique<rtl::Wire<Value>>());
        port(*signals_.back());
        seen_.emplace_back();
    }
    bool sample() override {
        bool right = true;
        for (std::size_t i = 0; i < signals_.size(); ++i) {
            const Value& value = signals_[i]->read();
            this->keep(seen_[i], value);
            right = right && (!checked_ || value == this->value_);
        }
        this->keep(dues_, checked_ ? this->value_ : seen_.front().back());
        return right;
    }
    std::string picture() const override {
        static constexpr const char* kUngated = "\n  without clock gating  ";
        std::string text = this->edges(seen_.front());
        for (std::size_t i = 1; i < seen_.size(); ++i) {
            if (!(seen_[i].back() == seen_.front().back())) text += kUngated + this->edges(seen_[i]);
        }
        const bool right = seen_.front().back() == dues_.back() && seen_.back().back() == dues_.back();
        return right ? text : text + "\n  due                   " + this->edges(dues_);
    }

  private:
    std::vector<std::unique_ptr<rtl::Wire<Value>>> signals_;
    bool checked_ = false;
    std::vector<std::deque<Value>> seen_;  ///< of each block
    std::deque<Value> dues_;
};

}  // namespace metabuffer::test

#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <systemc>
#include <utility>

#include "rtl/wire.h"

namespace metabuffer::rtl {

// The pins of a block. A pin's port is SystemC's own: it is a child of the module, has the pin's name and is bound as any
// port. It lies elsewhere in memory, since ports are large: what a block needs at each edge lies together.

/// An input: an sc_in that reads the signal's value where it lies, without a virtual call.
template <typename Value>
class In final {
  public:
    using data_type = Value;

    explicit In(const char* name) : port_(std::make_unique<Port>(name, value_)) {}
    In(const In&) = delete;
    In& operator=(const In&) = delete;

    /// Once the pin is bound to a signal: if by way of a pin of the block that its own is a part of, after elaboration.
    const Value& read() const { return *value_; }

    template <typename Channel>
    void operator()(Channel&& channel) {
        port()(std::forward<Channel>(channel));
        // A clock that is a module may not be bound itself yet.
        auto* const signal = dynamic_cast<sc_core::sc_prim_channel*>(port().get_interface());
        if (signal != nullptr) value_ = &port()->read();
    }
    void operator()(In& of_whole) { port()(of_whole.port()); }
    sc_core::sc_in<Value>& port() const { return *port_; }
    operator sc_core::sc_in<Value>&() const { return port(); }

  private:
    class Port final : public sc_core::sc_in<Value> {
      public:
        Port(const char* name, const Value*& value) : sc_core::sc_in<Value>(name), value_(value) {}

      private:
        void end_of_elaboration() override {
            sc_core::sc_in<Value>::end_of_elaboration();
            value_ = &(*this)->read();
        }

        const Value*& value_;
    };

    const Value* value_ = nullptr;
    std::unique_ptr<Port> port_;
};

/// An output: an sc_out that writes to a Wire without a virtual call.
template <typename Value>
class Out final {
  public:
    using data_type = Value;

    explicit Out(const char* name) : port_(std::make_unique<Port>(name, wire_)) {}
    Out(const Out&) = delete;
    Out& operator=(const Out&) = delete;

    void write(const Value& value) {
        if (wire_ != nullptr) {
            wire_->write(value);
        } else {
            port().write(value);
        }
    }
    const Value& read() const { return wire_ != nullptr ? wire_->read() : port().read(); }

    template <typename Channel>
    void operator()(Channel&& channel) {
        port()(std::forward<Channel>(channel));
    }
    void operator()(Out& of_whole) { port()(of_whole.port()); }
    sc_core::sc_out<Value>& port() const { return *port_; }
    operator sc_core::sc_out<Value>&() const { return port(); }

  private:
    class Port final : public sc_core::sc_out<Value> {
      public:
        Port(const char* name, Wire<Value>*& wire) : sc_core::sc_out<Value>(name), wire_(wire) {}

      private:
        void end_of_elaboration() override {
            sc_core::sc_out<Value>::end_of_elaboration();
            wire_ = dynamic_cast<Wire<Value>*>(this->get_interface());
        }

        Wire<Value>*& wire_;
    };

    Wire<Value>* wire_ = nullptr;
    std::unique_ptr<Port> port_;
};

/// Pins of one kind, named as those of an sc_vector: NAME_0 and so on.
template <typename Pin>
class PinVector final {
  public:
    using element_type = Pin;

    PinVector(const char* name, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            pins_.emplace_back((std::string(name) + '_' + std::to_string(i)).c_str());
        }
    }

    std::size_t size() const { return pins_.size(); }
    Pin& operator[](std::size_t i) { return pins_[i]; }
    const Pin& operator[](std::size_t i) const { return pins_[i]; }
    auto begin() { return pins_.begin(); }
    auto end() { return pins_.end(); }
    auto begin() const { return pins_.begin(); }
    auto end() const { return pins_.end(); }

  private:
    std::deque<Pin> pins_;
};

}  // namespace metabuffer::rtl

#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// A formula over named values, in the syntax of SQL expressions: `bus.width_bits >= 64 and bus.arbitration <> 'edf'`.
/// Names are scenario keys or figures of a run, written plainly or in double quotes; texts stand in single quotes.
/// Operators and functions are those of SQLite that depend on nothing but their operands: there are no subqueries,
/// tables or files. Evaluated by SQLite.
class Expression {
  public:
    /// `names` may appear in it; `where` begins the message of an error. Throws InputError for what is no expression
    /// and for unknown names, of which it tells the nearest known one.
    Expression(const std::string& text, const std::vector<std::string>& names, const std::string& where);
    Expression(Expression&&) noexcept;
    Expression& operator=(Expression&&) noexcept;
    ~Expression();

    const std::string& text() const;
    /// The names that it uses, each once.
    const std::vector<std::string>& names() const;
    /// Its value, given those of its names. Throws InputError if it has none for these (say, abs() of the least
    /// whole number).
    Value evaluate(const std::function<Value(const std::string& name)>& value_of_name) const;
    /// Whether that is true: neither nothing nor zero. Throws InputError for a text, which is neither true nor false.
    bool holds(const std::function<Value(const std::string& name)>& value_of_name) const;

  private:
    struct Statement;
    std::unique_ptr<Statement> statement_;
};

/// `text`, checked as Expression does it, with every name in double quotes: an expression that may stand in an SQL
/// statement over columns of these names. Throws InputError, `where` first.
std::string sql_expression(const std::string& text, const std::vector<std::string>& names,
                           const std::string& where);

/// The expressions of a list with commas in between; commas in parentheses and quotes are theirs. None is checked.
std::vector<std::string> split_expressions(const std::string& text);

/// A name as SQL takes it whatever is in it: in double quotes.
std::string quoted_name(const std::string& name);

/// The functions that an expression may use, in order.
const std::vector<std::string>& expression_functions();

}  // namespace metabuffer::exploration

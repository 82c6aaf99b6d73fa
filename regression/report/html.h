// Small pieces of HTML. Everything that comes from a file goes through escape() exactly once, on its way into
// the page; strings named *_html are markup already.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace report {

// For text and for attributes in double quotes. Control characters, which HTML does not allow, become U+FFFD.
std::string escape(std::string_view text);

// ` name="value"`, value escaped.
std::string attribute(const std::string& name, std::string_view value);

// So many significant digits; "not finite" for nothing, which is how results write such numbers.
std::string number_text(const std::optional<double>& value, int digits = 3);
std::string percent_text(const std::optional<double>& fraction);  // "0.41 %"
std::string signed_percent_text(const std::optional<double>& fraction);

// A verdict as a coloured word. `as_expected` is for witnesses whose difference the case expects.
std::string badge(const std::string& verdict, bool passed, const std::string& before = "",
                  bool as_expected = false);

}  // namespace report

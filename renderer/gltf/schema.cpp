// Checks and completes a document by schema.json. Its words are those of JSON Schema as far as they go: type,
// properties, required, additionalProperties, items, minItems, maxItems, minimum, maximum, enum, default, and
// $ref to a name in $defs. Further:
//   index     the value is an index into the array at this JSON pointer
//   clamp     a number out of its range is brought into it, with a warning
//   becomes   what the renderer makes of it; if that starts with "not", it is taken out, with a warning
//   not_both  pairs of members of which one at most may be there
//   others    warning about a member that is not in `properties`, * being its name
//   near      members that start so and are not in `properties` are errors that name the nearest one
// Members that the schema does not know are taken out, so that nobody downstream spends memory on them.
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <regex>

#include "base/text.h"
#include "gltf/guard.h"
#include "gltf/schema_text.h"

namespace gltf {
using nlohmann::json;

namespace {

const json& schema() {
  static const json parsed = json::parse(schema_text);
  return parsed;
}

// "an integer in [0, 6]"
std::string phrase(const json& schema) {
  const std::string type = schema["type"];
  std::string out = (std::string("aio").find(type[0]) == std::string::npos ? "a " : "an ") + type;
  if (schema.contains("maximum"))
    return out + " in [" + schema["minimum"].dump() + ", " + schema["maximum"].dump() + ']';
  return schema.contains("minimum") ? out + " of at least " + schema["minimum"].dump() : out;
}

struct Checker {
  const Document& document;
  Warnings& warnings;

  void check(json& value, const json& rule, const std::string& place) {
    if (rule.contains("$ref")) check(value, schema()["$defs"][rule["$ref"].get<std::string>()], place);
    if (rule.contains("type")) check_type(value, rule, place);
    if (rule.contains("enum")) check_choice(value, rule["enum"], place);
    if (rule.contains("index")) check_index(value, rule["index"], place);
    if (value.is_object()) check_members(value, rule, place.empty() ? "" : place + '.');
    if (!value.is_array()) return;
    if (const size_t least = rule.value("minItems", size_t{0}), most = rule.value("maxItems", value.size());
        value.size() < least || value.size() > most)
      document.fail(place, std::to_string(least) + " elements", value.size());
    if (rule.contains("items"))
      for (size_t i = 0; i < value.size(); ++i) check(value[i], rule["items"], at(place, i));
  }

  void check_type(json& value, const json& rule, const std::string& place) {
    const std::string type = rule["type"];
    if (!(type == "integer" ? value.is_number_integer() : value.type_name() == type))
      document.fail(place.empty() ? "JSON" : place, phrase(rule),
                    value.is_string() ? json("the string " + shown(value)) : value);
    if (!value.is_number()) return;
    const double x = value,
                 y = std::clamp(x, rule.value("minimum", -DBL_MAX), rule.value("maximum", DBL_MAX));
    // What float cannot hold is no slip of a user's.
    if (std::fabs(x) > FLT_MAX || (x != y && !rule.contains("clamp")))
      document.fail(place, phrase(rule), value);
    if (x == y) return;
    warnings.add(place + " is " + shown(value) + ": clamped to " + json(y).dump());
    value = y;
  }

  void check_choice(const json& value, const json& choices, const std::string& place) const {
    if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
    std::string all;
    for (const json& choice : choices) all += (all.empty() ? "" : ", ") + shown(choice);
    document.fail(place, (choices.size() > 1 ? "one of " : "") + all, value);
  }

  void check_index(const json& value, const std::string& array, const std::string& place) const {
    const json::json_pointer pointer(array);
    const size_t size = document.json.contains(pointer) ? document.json[pointer].size() : 0;
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= size)
      document.fail(place, "an index below " + std::to_string(size) + " (of " + array.substr(1) + ')', value);
  }

  void check_members(json& value, const json& rule, const std::string& prefix) {
    for (const std::string name : list(rule, "required"))
      if (!value.contains(name)) document.fail(prefix + name, "it, for it is required", "nothing");
    for (const std::vector<std::string> pair : list(rule, "not_both"))
      if (value.contains(pair[0]) && value.contains(pair[1]))
        document.fail(prefix.substr(0, prefix.size() - 1), pair[0] + " or " + pair[1], "both");
    const json& properties = list(rule, "properties");
    for (const auto& [name, property] : properties.items()) {
      if (property.contains("default") && !value.contains(name)) value[name] = property["default"];
      const auto found = value.find(name);
      if (found == value.end()) continue;
      check(*found, property, prefix + name);
      if (!property.value("becomes", "").starts_with("not")) continue;
      static const std::regex number("\\[[0-9]+\\]");  // one warning for all elements of an array
      warnings.add(std::regex_replace(prefix + name, number, "[]") + " is " +
                   property["becomes"].get<std::string>());
      value.erase(found);
    }
    for (const auto& [name, member] : value.items()) {
      if (properties.contains(name)) continue;
      if (rule.contains("additionalProperties")) check(member, rule["additionalProperties"], prefix + name);
      if (rule.contains("near") && name.starts_with(rule["near"].get<std::string>()))
        fail_near(prefix.substr(0, prefix.size() - 1), name.substr(0, 60), properties);
      if (!rule.contains("others")) continue;
      std::string warning = rule["others"];
      warnings.add(warning.replace(warning.find('*'), 1, name));
    }
    if (!rule.contains("properties") || rule.contains("additionalProperties")) return;
    for (auto member = value.begin(); member != value.end();)
      member = properties.contains(member.key()) || member.key() == "name" ? std::next(member)
                                                                           : value.erase(member);
  }

  [[noreturn]] void fail_near(const std::string& place, const std::string& name,
                              const json& properties) const {
    std::vector<std::string> known;
    for (const auto& [key, unused] : properties.items()) known.push_back(key);
    const auto nearer = [&](const std::string& a, const std::string& b) {
      return base::edit_distance(name, a) < base::edit_distance(name, b);
    };
    document.fail(place, *std::min_element(known.begin(), known.end(), nearer) + ", the nearest known key",
                  name);
  }
};

}  // namespace

std::string shown(const json& value) {
  if (value.is_null()) return "nothing";
  if (value.is_structured()) return value.type_name();
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return value.is_string() && text.size() > 2 ? text.substr(1, std::min<size_t>(text.size() - 2, 60)) : text;
}

void check_schema(Document& document, Warnings& warnings) {
  Checker{document, warnings}.check(document.json, schema(), "");
  const std::vector<std::string> known = supported_extensions();
  for (const std::string name : list(document.json, "extensionsUsed"))
    if (std::find(known.begin(), known.end(), name) == known.end())
      warnings.add("extension " + name + " is not rendered");
}

std::vector<std::string> supported_extensions() {
  return schema()["properties"]["extensionsRequired"]["items"]["enum"];
}

}  // namespace gltf

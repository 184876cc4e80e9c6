#include "import/column_words.h"

#include <algorithm>
#include <cctype>

#include "base/text.h"
#include "import/unit.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

using W = WordClass;

/// Words of columns in small letters: English, German, French and some more.
constexpr std::pair<WordClass, std::string_view> kClasses[] = {
    {W::kTime,
     "time|timestamp|t|zeit|uhrzeit|zeitstempel|epoch|elapsed|datetime|clock|stamp|unixtime|temps|heure|"
     "horodatage|tempo|tiempo|hora"},
    {W::kDate, "date|datum|day|fecha"},
    {W::kFeature, "feature|ball|balls|sphere|kugel|merkmal|artefact|artifact|bille|sfera|esfera"},
    {W::kDeviation,
     "deviation|dev|abweichung|abw|deviations|écart|ecart|scarto|scostamento|desviación|desviacion"},
    {W::kError,
     "error|err|fehler|messabweichung|erreur|errore|difference|diff|differenz|delta|δ|messuhr|feinzeiger|"
     "comparateur"},
    {W::kReference, "reference|ref|true|referenz|tracker"},
    {W::kStd, "std|sigma|stddev|stdev|sd"},
    {W::kVelocity, "velocity|vel|speed|geschwindigkeit|feedrate|vorschub|vitesse|velocità|velocidad"},
    {W::kTemperature, "temp|temperature|temperatur|thermocouple|pt100|température|temperatura"},
    {W::kSetup, "setup|aufstellung|fixturing"},
    {W::kPlacement, "placement|aufspannung|lage|placering|posage"},
    {W::kStylus, "stylus|styli|taster|tasteinsatz|palpeur|stilo"},
    {W::kRun, "run|cycle|lauf|zyklus|pass|durchlauf|durchgang|messlauf|messreihe|passe|passage|essai"},
    {W::kDirection, "direction|dir|richtung|fahrtrichtung|anfahrrichtung|verfahrrichtung|sens"},
    {W::kDisplay, "anzeige|ablesung|affichage|lecture|readout|indication"},
    {W::kReading, "reading|laser"},
    {W::kTarget,
     "target|nominal|soll|sollwert|commanded|command|cmd|set|setpoint|sollposition|zielposition|cible|"
     "consigne|théorique|nominale|objetivo"},
    {W::kMeasured,
     "measured|meas|ist|istwert|istposition|actual|act|indicated|gemessen|messwert|mesure|mesuré|réel|réelle|"
     "mesurée|misurato|misurata|medido|medida"},
    {W::kIndex, "n|no|nr|index|idx|number|id|row|pt|point|punkt|seq|i|num|lfd|sample|unnamed|zeile|ligne"},
    {W::kNote,
     "note|notes|comment|comments|remark|remarks|operator|bemerkung|kommentar|status|prüfer|bediener|"
     "anmerkung|commentaire|remarque|remarques|opérateur|operatore|operador"},
    {W::kFiller,
     "pos|position|axis|achse|axe|stellung|achsposition|coord|coordinate|machine|mcs|joint|value|encoder|"
     "scale|in|of|the|is|at"},
};

/// A unit of two parts: x_velocity_mm_s.
std::size_t unitCut(const std::string& name) {
  for (std::size_t at = name.rfind('_'), parts = 0; at != std::string::npos && parts < 2;
       at = at == 0 ? std::string::npos : name.rfind('_', at - 1), ++parts)
    if (parts == 1 && parseUnit(name.substr(at + 1))) return at;
  return name.rfind('_');
}

bool saysTime(const std::string& name) {
  const std::vector<std::string> words = wordsOf(name);
  return std::any_of(words.begin(), words.end(),
                     [](const std::string& word) { return classOf(word) == WordClass::kTime; });
}

}  // namespace

std::optional<WordClass> classOf(std::string_view word) {
  for (const auto& [known, words] : kClasses)
    if (isOneOf(word, words)) return known;
  return std::nullopt;
}

NameAndUnit splitUnit(const std::string& written) {
  const std::string name(trim(written));
  for (const auto& [open, close] : {std::pair('[', ']'), std::pair('(', ')'), std::pair('{', '}')}) {
    const std::size_t begin = name.rfind(open), end = name.rfind(close);
    if (begin == std::string::npos || end == std::string::npos || end < begin) continue;
    const std::string inside(trim(name.substr(begin + 1, end - begin - 1)));
    const std::string stem(trim(name.substr(0, begin) + " " + name.substr(end + 1)));
    if (!stem.empty() && !inside.empty()) return {stem, inside};
  }
  for (const char mark : {'/', ',', ' '}) {
    const std::size_t at = mark == '/' ? name.find(mark) : name.rfind(mark);
    if (at == std::string::npos || at == 0) continue;
    const std::string unit(trim(name.substr(at + 1)));
    const auto parsed = parseUnit(unit);
    // a word that may be a unit is one only where nothing else ends so: "ball s" has none
    const bool single = unit.size() == 1 && mark == ' ' &&
                        (!parsed || (parsed->kind != UnitKind::kTemperature &&
                                     !(parsed->kind == UnitKind::kTime && saysTime(name.substr(0, at)))));
    if (parsed && !single) return {std::string(trim(name.substr(0, at))), unit};
  }
  const std::size_t cut = unitCut(name);
  if (cut != std::string::npos && cut > 0) {
    const std::string unit = name.substr(cut + 1);
    const std::string stem = name.substr(0, cut);
    const bool percent = unit == "percent" || unit == "hPa" || unit == "kPa" || unit == "Pa" || unit == "N";
    if (parseUnit(unit) || percent) return {stem, unit};
  }
  return {name, ""};
}

std::vector<std::string> wordsOf(std::string_view name) {
  std::vector<std::string> words;
  std::string word;
  std::string small = lower(name);
  for (std::size_t i = 1; i < small.size(); ++i) {  // É, Ä … of UTF-8
    const auto c = static_cast<unsigned char>(small[i]);
    if (small[i - 1] == '\xc3' && c >= 0x80 && c <= 0x9e && c != 0x97) small[i] = static_cast<char>(c + 0x20);
  }
  for (const char c : small) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 0x80) {
      word += c;
    } else if (!word.empty()) {
      words.push_back(word);
      word.clear();
    }
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

}  // namespace mm

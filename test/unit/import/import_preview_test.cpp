#include "import/import_preview.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "base/cancel_scope.h"
#include "base/text.h"
#include "import_support.h"

namespace mm {
namespace {

using test::Folder;
using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty, ::testing::Not, ::testing::SizeIs;

ImportPreview previewOf(const std::filesystem::path& file, const Machine& machine,
                        const Artifact* artifact = nullptr, const std::string& mapping = "") {
  ImportRequest request;
  request.file = file;
  request.mappingText = mapping;
  return previewImport(request, machine, artifact);
}

ImportPreview previewOfText(const std::string& text, const std::string& mapping = "",
                            const std::string& machine = "three_axis") {
  ImportRequest request;
  request.file = "sent.csv";
  request.content = std::make_shared<const std::string>(text);
  request.mappingText = mapping;
  return previewImport(request, Machine::load(machine), nullptr);
}

/// "name: meaning, unit" of each column.
std::vector<std::string> understood(const ImportPreview& preview) {
  std::vector<std::string> all;
  for (const UnderstoodColumn& c : preview.imported.columns)
    all.push_back(c.name + ": " + c.meaning + (c.unit.empty() ? "" : ", " + c.unit));
  return all;
}

/// A file as a person reads it who has it before him.
struct Example {
  const char *file, *machine, *format;
  std::vector<std::string> columns;
  std::vector<std::string> firstRow;
};

class ExampleFiles : public ::testing::TestWithParam<Example> {};

TEST_P(ExampleFiles, AreUnderstoodAsAPersonReadsThem) {
  const Example& e = GetParam();
  const ImportPreview preview = previewOf(std::string("examples/") + e.file, Machine::load(e.machine));
  ASSERT_THAT(preview.faults, IsEmpty());
  EXPECT_EQ(preview.imported.format, e.format);
  EXPECT_EQ(understood(preview), e.columns);
  if (e.firstRow.empty()) {
    EXPECT_THAT(preview.imported.rows, IsEmpty());
  } else {
    ASSERT_THAT(preview.imported.rows, Not(IsEmpty()));
    EXPECT_LE(preview.imported.rows.size(), kRowsShown);
    EXPECT_EQ(preview.imported.rows.front(), e.firstRow);
  }
  EXPECT_THAT(preview.imported.head, Not(IsEmpty()));
  EXPECT_LE(preview.imported.head.size(), kLinesShown);
}

const std::string kTouch = "z at the trigger: with opposite sign, the deviation of z from the bed, mm";

INSTANTIATE_TEST_SUITE_P(
    Each, ExampleFiles,
    ::testing::Values(
        Example{"import/ball_bar_xy.csv",
                "three_axis",
                "ballbar",
                {"Angle [deg]: angle in the plane, deg", "Deviation [um]: deviation of the radius, um"},
                {"0", "0.029"}},
        Example{
            "import/iso230_2_x.csv",
            "three_axis",
            "iso230-2",
            {"Target [mm]: target position, mm", "1+: run 1, upwards, um", "1-: run 1, downwards, um",
             "2+: run 2, upwards, um", "2-: run 2, downwards, um", "3+: run 3, upwards, um",
             "3-: run 3, downwards, um", "4+: run 4, upwards, um", "4-: run 4, downwards, um",
             "5+: run 5, upwards, um", "5-: run 5, downwards, um"},
            {"-18,000", "-2,39", "1,69", "-2,38", "1,61", "-2,45", "1,62", "-2,25", "1,68", "-2,26", "1,66"}},
        Example{"import/iso230_2_z_by_runs.txt", "three_axis", "iso230-2", {}, {}},
        Example{"import/klipper_probe_accuracy.txt", "three_axis", "klipper", {kTouch}, {}},
        Example{"import/marlin_g30.txt", "three_axis", "marlin", {kTouch}, {}},
        Example{"import/marlin_m48.txt", "three_axis", "marlin", {kTouch}, {}},
        Example{"import/length_bars_y.csv",
                "three_axis",
                "step-gauge",
                {"calibrated [mm]: calibrated length, mm",
                 "error [um]: error of indication, indicated minus calibrated, um", "bar: placement or bar"},
                {"5.00012", "-0.21", "A"}},
        Example{"import/step_gauge_x.txt",
                "three_axis",
                "step-gauge",
                {"calibrated (mm): calibrated length, mm", "indicated (mm): indicated length, mm"},
                {"0.0000", "0.00018"}},
        Example{"import/r_test_ba.csv",
                "five_axis",
                "r-test",
                {"Y [mm]: reading of joint y, mm", "X [mm]: reading of joint x, mm",
                 "Z [mm]: reading of joint z, mm", "B [deg]: reading of joint b, deg",
                 "A [deg]: reading of joint a, deg", "dx [um]: displacement of the ball in workpiece, um",
                 "dy [um]: displacement of the ball in workpiece, um",
                 "dz [um]: displacement of the ball in workpiece, um"},
                {"40.0000", "-122.3205", "3.6603", "-90", "-60", "-11.85", "11.96", "-0.14"}},
        Example{"tutorials/bed_mesh.log", "three_axis", "klipper", {kTouch}, {}},
        Example{"tutorials/tracker.csv",
                "three_axis",
                "table",
                {"time_s: time, s", "x_mm: reading of joint x, mm", "y_mm: reading of joint y, mm",
                 "z_mm: reading of joint z, mm", "reference_x_mm: true position x, mm",
                 "reference_y_mm: true position y, mm", "reference_z_mm: true position z, mm"},
                {"0", "20", "20", "-250", "2156.8550", "-802.5510", "161.9917"}}),
    [](const auto& info) {
      std::string name = info.param.file;
      for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
      return name;
    });

TEST(ImportPreview, ContactsWantTheirArtifact) {
  const std::string file = "examples/tutorials/plate_contacts.csv";
  const Machine machine = Machine::load("three_axis");
  const ImportPreview without = previewOf(file, machine);
  ASSERT_THAT(without.faults, ElementsAre(HasSubstr("give the artifact")));
  EXPECT_FALSE(without.imported.session);
  EXPECT_THAT(understood(without), ::testing::Contains("x_velocity_mm_s: velocity of joint x, mm/s"));
  const Artifact plate = loadArtifact("examples/tutorials/plate.yaml");
  const ImportPreview with = previewOf(file, machine, &plate);
  EXPECT_THAT(with.faults, IsEmpty());
  ASSERT_TRUE(with.imported.session);
  EXPECT_GT(with.imported.session->observations.size(), 90u);
}

TEST(ImportPreview, ABrokenCellIsNamedByLineAndColumn) {
  const ImportPreview own = previewOfText("time_s,x_mm,deviation_x_um\n0,1,2\n1,oops,2\n");
  ASSERT_THAT(own.faults, ElementsAre(HasSubstr("sent.csv:3: column 'x_mm': 'oops'")));
  EXPECT_THAT(understood(own), SizeIs(3)) << "what was understood of a file that is refused";
  EXPECT_THAT(own.imported.rows, SizeIs(2));
  const ImportPreview other = previewOfText("Zeit [s];X [mm];Abweichung X [um]\n0;1;2\n1;2;x2\n");
  EXPECT_THAT(other.faults, ElementsAre(AllOf(HasSubstr("sent.csv:3:"), HasSubstr("Abweichung X"))));
}

TEST(ImportPreview, AColumnThatIsMissingIsSaidOnce) {
  std::string rows = "time_s,x_mm,y_mm\n", lengths = "time_s,x_mm,length_mm\n";
  for (int i = 0; i < 225; ++i) {
    rows += std::to_string(i) + ",1,2\n";
    lengths += std::to_string(i) + ",1,2\n";
  }
  EXPECT_THAT(previewOfText(rows).faults,
              ElementsAre(AllOf(HasSubstr("sent.csv:1: no column holds a measurement"),
                                HasSubstr("'deviation_x_um'"), HasSubstr("'feature'"))));
  EXPECT_THAT(previewOfText(lengths).faults, ElementsAre(HasSubstr("column 'feature' is missing")));
}

TEST(ImportPreview, AsksWithChoicesAndTakesTheAnswer) {
  const std::string text = "Zeit [s];X [mm];Error X [um]\n0;1;1,5\n1;2;2,5\n";
  const ImportPreview preview = previewOfText(text);
  ASSERT_THAT(preview.asked, SizeIs(1));
  EXPECT_EQ(preview.asked[0].key, "columns");
  EXPECT_EQ(preview.asked[0].column, "Error X [um]");
  EXPECT_EQ(preview.asked[0].suggested, "error_x_um");
  EXPECT_THAT(preview.asked[0].choices, ::testing::IsSupersetOf({"error_x_um", "deviation_x_um", "ignore"}));
  const ImportPreview answered = previewOfText(text, "columns: {\"Error X [um]\": \"error_x_um\"}\n");
  EXPECT_THAT(answered.faults, IsEmpty());
  EXPECT_THAT(answered.asked, IsEmpty());
  ASSERT_TRUE(answered.imported.session);
  EXPECT_NEAR(answered.imported.session->observations[0].deviation[0], -1.5e-6, 1e-12);
}

TEST(ImportPreview, EveryKindOfQuestionIsAsked) {
  const auto keys = [](const ImportPreview& preview) {
    std::vector<std::string> all;
    for (const ImportQuestion& q : preview.asked)
      all.push_back(q.key + (q.column.empty() ? "" : ": " + q.column));
    return all;
  };
  EXPECT_THAT(keys(previewOfText("ball bar\nAngle [deg];Deviation [um]\n0;1\n90;2\n180;1\n270;0.5\n")),
              ElementsAre("plane", "radius_mm", "centre_mm"));
  EXPECT_THAT(keys(previewOfText("1;2;3\n2;3;4\n")), ElementsAre("columns: 1", "columns: 2", "columns: 3"));
  EXPECT_THAT(keys(previewOfText("X;Y;Ref X\n1;1;3\n2;1;4\n")), ::testing::Contains("columns: Ref X"));
  const ImportPreview noJoint = previewOfText("Position [mm];Deviation [um]\n1;1.5\n2;2.5\n");
  ASSERT_THAT(keys(noJoint), ::testing::Contains("axis"));
  const auto axis = std::find_if(noJoint.asked.begin(), noJoint.asked.end(),
                                 [](const ImportQuestion& q) { return q.key == "axis"; });
  EXPECT_THAT(axis->choices, ElementsAre("x", "y", "z"));
}

TEST(ImportPreview, DoubtsAreOfTheSession) {
  const ImportPreview preview =
      previewOfText("time_s,x_mm,deviation_x_um\n0,-16000,1.5\n10,0,2.5\n20,16000,3.5\n");
  ASSERT_THAT(preview.faults, IsEmpty());
  ASSERT_THAT(preview.doubts, SizeIs(1));
  EXPECT_THAT(previewText(preview), HasSubstr("question: x is -16000 … 16000 mm"));
}

TEST(ImportPreview, EveryChoiceOfAColumnIsUnderstood) {
  const Machine machine = Machine::load("five_axis");
  for (const ColumnChoice& c : columnChoices(machine)) {
    const ColumnMapping mapping = parseColumnMapping("columns: {q: " + c.value + "}", "mapping");
    EXPECT_EQ(mapping.columns.at("q"), c.value);
    const ImportPreview preview =
        previewOfText("q;w\n1;2\n2;3\n", "columns: {q: " + c.value + ", w: ignore}\n", "five_axis");
    for (const std::string& fault : preview.faults)
      EXPECT_THAT(fault, Not(HasSubstr("is not understood"))) << c.value;
    ASSERT_THAT(preview.imported.columns, Not(IsEmpty())) << c.value;
    const UnderstoodColumn& q = preview.imported.columns[0];
    if (c.value == "ignore") {
      EXPECT_EQ(q.meaning, "ignored by the mapping");
      continue;
    }
    const std::string meant = q.meaning.substr(0, q.meaning.find(','));
    if (startsWith(c.value, "error_"))  // the same quantity with its sign changed
      EXPECT_EQ("error" + meant.substr(meant.find(" of ")), c.words.substr(0, c.words.find(','))) << c.value;
    else
      EXPECT_EQ(meant, c.words.substr(0, c.words.find(','))) << c.value;
    if (!q.unit.empty()) {
      EXPECT_TRUE(endsWith(c.words, ", " + q.unit)) << c.words;
    }
  }
}

TEST(ImportPreview, AFileWithoutEndIsShownByItsBeginning) {
  const std::string text = std::string(100000, 'a') + "\n" + std::string(100000, 'b') + "\n";
  const ImportPreview preview = previewOfText(text);
  ASSERT_THAT(preview.imported.head, SizeIs(2));
  for (const std::string& line : preview.imported.head) EXPECT_EQ(line, std::string(120, line[0]) + "…");
}

TEST(ImportPreview, ALongNameAndALongCellAreCut) {
  std::string name, cell;
  for (int i = 0; i < 5000; ++i) name += "ä", cell += "é";
  const auto bounded = [](const ImportPreview& preview) {
    ASSERT_THAT(preview.faults, Not(IsEmpty()));
    EXPECT_LT(previewText(preview).size() + firstRowsText(preview.imported).size(), 6000u);
    EXPECT_LT(jsonLine(previewJson({}, preview, "")).size(), 12000u) << "or it is cut within a letter";
    for (const std::string& fault : preview.faults) EXPECT_LT(fault.size(), 2000u) << fault;
  };
  bounded(previewOfText("Zeit [s];X [mm];" + name + "\n0;1;2\n1;2;3\n"));
  bounded(previewOfText("Zeit [s];X [mm];Abweichung X [um]\n0;1;2\n1;2;" + cell + "\n"));
  bounded(previewOfText("time_s,x_mm,deviation_x_um\n0,1," + cell + "\n"));
  bounded(previewOfText("time_s,x_mm," + name + "_V\n0,1,2\n"));
}

TEST(ImportPreview, WhatSteersATerminalIsNotShown) {
  const std::string text =
      "Zeit [s];X [mm];\x1b[31mred;Abweichung X [um]\n0;1;2;\x1b]0;t\x07\n1;2;3;4\n2;3;\xC2\x9B"
      "1;5\n";
  const ImportPreview preview = previewOfText(text);
  ASSERT_THAT(preview.faults, Not(IsEmpty()));
  std::string all = previewText(preview) + firstRowsText(preview.imported);
  for (const std::string& fault : preview.faults) all += fault;
  EXPECT_EQ(all.find_first_of("\x1b\x07\x7f"), std::string::npos) << all;
  EXPECT_EQ(all.find("\xC2\x9B"), std::string::npos) << all;
  EXPECT_THAT(all, HasSubstr("\uFFFD[31mred"));
  EXPECT_THAT(all, HasSubstr("columns: {3: ignore}"))
      << "a name that cannot be typed is called by its number";
}

TEST(ImportPreview, AWideFileIsRefusedAtOnce) {
  const auto file = [](std::size_t columns, const std::string& ending) {
    std::string names, row;
    for (std::size_t i = 0; i < columns; ++i) {
      names += (i > 0 ? ",n" : "n") + std::to_string(i) + ending;
      row += i > 0 ? ",1.5" : "1.5";
    }
    return "# a remark\n" + names + "\n" + row + "\n" + row + "\n";
  };
  EXPECT_THAT(previewOfText(file(100000, "")).faults,
              ElementsAre(HasSubstr("sent.csv:2: 100000 columns, at most 2000")));
  const ImportPreview most = previewOfText(file(2000, ""));
  EXPECT_THAT(most.imported.columns, SizeIs(2000));
  EXPECT_THAT(most.faults, SizeIs(FaultList::kShown + 1));
  EXPECT_THAT(previewOfText("time_s,x_mm,deviation_x_um," + file(3000, "_V").substr(11)).faults,
              ElementsAre(HasSubstr("sent.csv:1: 3003 columns, at most 2000")));
}

TEST(ImportPreview, EndsWhereItIsCancelled) {
  int asked = 0;
  const CancelScope scope([&] { return ++asked > 3; });
  EXPECT_THROW(previewOfText("Zeit [s];X [mm];Abweichung X [um]\n0;1;2\n1;2;3\n2;3;4\n3;4;5\n"), Cancelled);
}

TEST(ImportPreview, ANameWithQuotesAnswersItsQuestion) {
  const std::string text = "Zeit [s];X [mm];Error X' {a}: [um]\n0;1;1,5\n1;2;2,5\n";
  const ImportPreview preview = previewOfText(text);
  ASSERT_THAT(preview.asked, SizeIs(1));
  EXPECT_EQ(preview.asked[0].column, "Error X' {a}: [um]");
  ASSERT_THAT(preview.faults, SizeIs(1));
  const std::string line = preview.faults[0].substr(preview.faults[0].find("columns: {"));
  EXPECT_THAT(previewOfText(text, line.substr(0, line.find(" for the first")) + "\n").faults, IsEmpty())
      << line;
}

}  // namespace
}  // namespace mm

// Bad inputs of every command: refused with one line that says what is wrong; nothing is lost, nothing is
// left.
#include "session_folder.h"

namespace mm {
namespace {

class Refusals : public SessionFolder {
 protected:
  static void SetUpTestSuite() {
    SessionFolder::SetUpTestSuite();
    const TestFolder& f = *folder_;
    f.write("empty", "");
    f.write("noise", std::string("\x01\x00\xff\xfe{[", 6));
    f.write("cut.bag", textOf(f / "s.bag").substr(0, 20000));  // two thirds of it
    f.write("short.bag", "#ROSBAG V2.0\n");
    f.write("unclosed.yaml", "machine: three_axis\neffects: [{type: scale\n");
    f.write("key.yaml", "machine: three_axis\neffects: []\ncolour: red\n");
    f.write("twice.yaml", "machine: three_axis\neffects: [{type: scale, axis: x}, {type: scale, axis: x}]\n");
    f.write("untyped.yaml", "machine: three_axis\neffects: [{axis: x}]\n");
    f.write("nomachine.yaml", "machine: lathe\neffects: []\n");
    f.write("five.yaml", "machine: five_axis\neffects: []\n");
    f.write("word.csv", "time_s,x_mm,deviation_x_um\n0,1,2\n1,two,3\n");
    f.write("column.csv", "time_s,x_mm,deviation_w_um\n0,1,2\n");
    f.write("cells.csv", "time_s,x_mm,deviation_x_um\n0,1,2,3\n");
    f.write("states_word.csv", "time_s,x_mm,y_mm,z_mm\n0,1,2,three\n");
    f.write("states_column.csv", "time_s,x_mm,y_mm,z_mm,b_deg\n0,1,2,3,4\n");
    f.write("broken.urdf", "<robot name=\"r\"><link name=\"workpiece\"/>");
    f.write("linkless.urdf", "<robot name=\"r\"><link name=\"workpiece\"/></robot>");
    f.write("far.yaml",
            "artifact: {name: a, pose: known, probe: {tip_radius_mm: 1}, balls: [{name: b, centre_mm: [500, "
            "0, 0], "
            "radius_mm: 4}]}\ntouch: {features: all, points: 5}\n");
    f.write("badplan.yaml", "name: p\ntouchh: {}\n");
    f.write("nothing.yaml", "name: p\n");
    f.write("radius.yaml", "name: a\nballs: [{name: b, centre_mm: [0, 0, 0], radius_mm: -4}]\n");
    f.write("reversed.urdf", reversed());
    f.write("reversed.yaml", "machine: reversed.urdf\neffects: [{type: scale, axis: x}]\n");
    run("import s.csv --machine reversed.urdf -o reversed.bag");
    f.write("slip.yaml",
            "machine: three_axis\neffects:\n  - {type: scale, axis: x}\n  - {type: scale, axs: y}\n");
    f.write("type.yaml", "machine: three_axis\neffects: [{type: backlsh, axis: x}]\n");
    f.write("map.yaml", "machine: three_axis\n  effects: []\n");
    f.write("semicolons.csv", "Zeit;X Position [mm];Abweichung [um]\n09:14:00;0,000;0,07\n");
    f.write("twin.urdf", twin());
    f.write("twin.yaml", "machine: twin.urdf\neffects: [{type: scale, axis: x}]\n");
    run("import s.csv --machine twin.urdf -o twin.bag");
    run("calibrate twin.bag --model twin.yaml --method least_squares -o twin_c.yaml");
    run("promote c.yaml --store filled");
    f.write("plotly.js", "/* plotly */" + std::string(100000, ' '));
    f.write("curve.csv", "generation,rms_um\n0,abc\n");
  }
  static std::string reversed() {
    std::string urdf = textOf("urdf/three_axis.urdf");
    const std::string axis = "<axis xyz=\"1 0 0\"/>";
    return urdf.replace(urdf.find(axis), axis.size(), "<axis xyz=\"-1 0 0\"/>");
  }
  /// A machine of the same build: nothing but its name differs.
  static std::string twin() {
    std::string urdf = textOf("urdf/three_axis.urdf");
    const std::string name = "<robot name=\"three_axis\">";
    return urdf.replace(urdf.find(name), name.size(), "<robot name=\"twin\">");
  }
};

struct Row {
  const char* typed;
  std::vector<std::string> words;  // that the line must hold
};

const std::vector<Row>& rows() {
  static const std::vector<Row> all{
      // words and options
      {"", {"subcommand"}},
      {"calibrat s.bag", {"calibrat", "did you mean", "calibrate"}},
      {"calibrate s.bag --model m.yaml --modle m.yaml", {"--modle"}},
      {"calibrate --model m.yaml", {"bag"}},
      {"compare s.bag", {"--calibration"}},
      {"machine", {"subcommand"}},
      {"plan old", {"old"}},
      {"check s.bag extra", {"extra"}},
      // numbers
      {"calibrate s.bag --model m.yaml --seed -1", {"--seed", "'-1'", "0 to 18446744073709551615"}},
      {"calibrate s.bag --model m.yaml --seed 1e3", {"--seed", "'1e3'"}},
      {"calibrate s.bag --model m.yaml --threads 9999", {"--threads", "'9999'", "0 to 1024"}},
      {"calibrate s.bag --model m.yaml --population 1", {"--population", "'1'", "2 to"}},
      {"calibrate s.bag --model m.yaml --generations many", {"--generations", "'many'"}},
      {"calibrate s.bag --model m.yaml --repeatability-um nan", {"--repeatability-um", "'nan'"}},
      {"calibrate s.bag --model m.yaml --repeatability-um 0", {"--repeatability-um", "'0'"}},
      {"calibrate s.bag --model m.yaml --crossover 1.5", {"--crossover", "'1.5'", "0 to 1"}},
      {"calibrate s.bag --model m.yaml --survivor-share 0.5", {"survivor_share"}},
      {"calibrate s.bag --model m.yaml --stages 10:1,5:1", {"stages"}},
      {"calibrate s.bag --model m.yaml --method newton", {"newton", "least_squares"}},
      {"apply states.csv --calibration c.yaml --margin -0.1 -o out.csv", {"--margin", "'-0.1'", "0 to 10"}},
      {"apply states.csv --calibration c.yaml --margin inf -o out.csv", {"--margin", "'inf'"}},
      {"simulate --machine three_axis --plan plan.yaml --seed 18446744073709551616 -o o.bag", {"--seed"}},
      {"sensors series.csv --target nose_um --max 0", {"--max", "'0'", "1 to 64"}},
      {"sensors series.csv --target nose_um --bins 1,30 --estimator histogram",
       {"--bins", "'1'", "2 to 10000"}},
      {"sensors series.csv --target nose_um --blocks 1", {"--blocks", "2 to 1000"}},
      {"sensors series.csv --target nose_um --accuracy-um -3", {"--accuracy-um", "'-3'"}},
      {"mm-benchmark --plan plan.yaml --trials 0", {"--trials", "'0'"}},
      {"mm-benchmark --plan plan.yaml --effects -1", {"--effects", "'-1'"}},
      {"mm-benchmark --plan plan.yaml --size 0", {"--size", "'0'"}},
      {"mm-benchmark --plan plan.yaml --oracle 7", {"--oracle", "'7'", "8 to 100000"}},
      {"add s.bag --calibration c.yaml --all --most 0", {"--most", "'0'"}},
      // sessions
      {"check none.bag", {"none.bag"}},
      {"check empty", {"empty"}},
      {"check noise", {"noise"}},
      {"check short.bag", {"short.bag"}},
      {"check s.csv", {"s.csv", "not a bag"}},
      {"check .", {"."}},
      {"check s.bag --namespace /m9", {"m9"}},
      {"calibrate c.yaml --model m.yaml", {"c.yaml"}},
      // models and effects
      {"calibrate s.bag --model unclosed.yaml", {"unclosed.yaml:"}},
      {"calibrate s.bag --model key.yaml", {"key.yaml:3", "colour"}},
      {"calibrate s.bag --model twice.yaml", {"twice", "scale"}},
      {"calibrate s.bag --model untyped.yaml", {"untyped.yaml:2", "type"}},
      {"calibrate s.bag --model nomachine.yaml", {"lathe"}},
      {"calibrate s.bag --model five.yaml", {"five_axis", "joints"}},
      {"calibrate s.bag --model s.bag", {"s.bag"}},
      {"calibrate s.bag --model reversed.yaml --method least_squares -o empty/x", {"empty"}},
      {"check s.bag --model five.yaml", {"five_axis"}},
      {"add s.bag --calibration c.yaml", {"--all"}},
      {"add s.bag --calibration c.yaml --all '{type: backlash, axis: x}'", {"--all", "omit"}},
      {"add s.bag --calibration c.yaml '{type: backlahs, axis: x}'", {"backlahs", "backlash"}},
      {"add s.bag --calibration c.yaml '{type: backlash, axis: w}'", {"'w'"}},
      {"add s.bag --calibration c.yaml '{type: straightness, axis: x, direction: y, degree: 99}'",
       {"degree", "99"}},
      {"add s.bag --calibration c.yaml '{type: scale, axis: x}'", {"already"}},
      {"add s.bag --calibration c.yaml 'scale'", {"map"}},
      {"remove s.bag --calibration c.yaml '{type: backlash, axis: x}'", {"not in the model"}},
      {"remove s.bag --calibration c.yaml --all '{type: scale, axis: x}'", {"--all"}},
      {"update s.bag --calibration c.yaml", {"network"}},
      {"effects backlsh", {"backlsh", "backlash"}},
      // calibrations, and sessions of another machine
      {"compare s.bag --calibration none.yaml", {"none.yaml"}},
      {"compare s.bag --calibration m.yaml", {"m.yaml"}},
      {"compare s.bag --calibration s.bag", {"s.bag"}},
      {"diagnose s.bag --calibration empty", {"empty"}},
      {"compare five.bag --calibration c.yaml", {"another machine", "joints x, y, z", "y, x, z, b, a"}},
      {"diagnose five.bag --calibration c.yaml", {"another machine", "joints x, y, z"}},
      {"add five.bag --calibration c.yaml '{type: backlash, axis: x}'", {"another machine"}},
      {"add five.bag --calibration c.yaml --all", {"another machine"}},
      {"remove five.bag --calibration c.yaml '{type: scale, axis: x}'", {"another machine"}},
      {"update five.bag --calibration c.yaml", {"another machine"}},
      {"report five.bag --calibration c.yaml --plotly plotly.js -o page.html", {"another machine"}},
      {"compare reversed.bag --calibration c.yaml", {"joint x moves along (1, 0, 0)", "(-1, 0, 0)"}},
      {"diagnose reversed.bag --calibration c.yaml", {"joint x moves along"}},
      {"report s.bag --calibration c.yaml --plotly none.js -o page.html", {"none.js"}},
      {"report s.bag --calibration c.yaml --plotly plotly.js --curve curve.csv -o page.html",
       {"curve.csv", "abc"}},
      {"compare s.bag --calibration twin_c.yaml",
       {"s.bag", "another machine ('three_axis')", "calibrated ('twin.urdf')", "its URDF calls it 'twin'"}},
      {"add s.bag --calibration twin_c.yaml '{type: backlash, axis: x}' -o y.yaml",
       {"'twin'", "'three_axis'"}},
      {"diagnose twin.bag --calibration c.yaml", {"twin.bag", "'twin'", "'three_axis'"}},
      {"calibrate twin.bag --model m.yaml",
       {"twin.bag", "another machine ('twin')", "model's ('three_axis')"}},
      {"check twin.bag --model m.yaml", {"twin.bag", "'twin'", "'three_axis'"}},
      {"promote twin_c.yaml --store filled",
       {"filled", "active", "'three_axis'", "'twin'", "another machine", "--store", "--force"}},
      {"promote none.yaml --store kept", {"none.yaml"}},
      {"promote m.yaml --store kept", {"m.yaml"}},
      {"promote 20200101T000000Z-00000000 --store kept", {"20200101T000000Z-00000000"}},
      {"promote --store kept", {"kept"}},
      {"rollback --store kept", {"kept"}},
      {"apply states.csv --store kept -o out.csv", {"kept", "--calibration"}},
      // tables
      {"import none.csv --machine three_axis -o o.bag", {"none.csv"}},
      {"import empty --machine three_axis -o o.bag", {"empty"}},
      {"import noise --machine three_axis -o o.bag", {"noise"}},
      {"import word.csv --machine three_axis -o o.bag", {"word.csv", "3", "two"}},
      {"import column.csv --machine three_axis -o o.bag", {"column.csv", "deviation_w_um"}},
      {"import cells.csv --machine three_axis -o o.bag", {"cells.csv", "2"}},
      {"import s.csv --machine lathe -o o.bag", {"lathe"}},
      {"import s.csv --machine broken.urdf -o o.bag", {"broken.urdf"}},
      {"import s.csv --machine linkless.urdf -o o.bag", {"linkless.urdf", "probe_tip"}},
      {"import s.csv --machine three_axis --artifact radius.yaml -o o.bag",
       {"radius.yaml", "radius_mm", "-4"}},
      {"import s.csv --machine three_axis --artifact s.bag -o o.bag", {"s.bag"}},
      {"apply none.csv --calibration c.yaml -o out.csv", {"none.csv"}},
      {"apply empty --calibration c.yaml -o out.csv", {"empty"}},
      {"apply states_word.csv --calibration c.yaml -o out.csv", {"states_word.csv", "three"}},
      {"apply states_column.csv --calibration c.yaml -o out.csv", {"states_column.csv", "b_deg"}},
      {"sensors series.csv --target tail_um", {"series.csv", "tail_um"}},
      {"sensors s.bag --target w", {"s.bag", "'w'"}},
      {"sensors s.bag --target x", {"temperature"}},
      {"sensors series.csv --target nose_um --estimator magic", {"--estimator", "ksg"}},
      {"sensors series.csv --target nose_um --positions none.csv --picture p.svg", {"none.csv"}},
      // plans, machines, simulations
      {"simulate --machine three_axis --plan none.yaml -o o.bag", {"none.yaml"}},
      {"simulate --machine three_axis --plan badplan.yaml -o o.bag", {"badplan.yaml:2", "touchh"}},
      {"simulate --machine three_axis --plan nothing.yaml -o o.bag", {"nothing.yaml", "measures nothing"}},
      {"simulate --machine three_axis --plan far.yaml -o o.bag", {"far.yaml"}},
      {"simulate --machine three_axis --plan plan.yaml --hide gremlin -o o.bag", {"gremlin"}},
      {"simulate --machine three_axis --plan plan.yaml --hide backlash:w=3um -o o.bag", {"w"}},
      {"simulate --machine three_axis --plan plan.yaml --hide backlash:x=3kg -o o.bag", {"3kg"}},
      {"simulate --machine three_axis --plan plan.yaml --hide thermal_growth=8um -o o.bag",
       {"--hide 'thermal_growth=8um'", "growth", "'8um'", "um/K", "e.g. thermal_growth="}},
      {"simulate --machine three_axis --plan plan.yaml --hide backlash:x=3um,period_mm=5 -o o.bag",
       {"--hide 'backlash:x=3um,period_mm=5'", "'period_mm'", "known are size, axis, gap"}},
      {"simulate --machine three_axis --plan plan.yaml --hide backlsh:x=3um -o o.bag",
       {"'backlsh' can be hidden; did you mean 'backlash'?; possible"}},
      // a slip is named for what it is
      {"calibrate s.csv --model m.yaml", {"s.csv", "is not a bag", "mm import"}},
      {"calibrate s.bag --modell m.yaml",
       {"'--modell' is not an option of mm calibrate", "did you mean '--model'?"}},
      {"calibrate none.bag --model m.yaml -o c.yaml", {"none.bag", "does it exist?"}},
      {"calibrate none.bag --model m.yaml -o s.csv", {"none.bag", "no such file"}},
      {"calibrate s.bag --model slip.yaml", {"slip.yaml:4:", "unknown key 'axs'; did you mean 'axis'?"}},
      {"check s.bag --model slip.yaml", {"slip.yaml:4:", "'axs'"}},
      {"calibrate s.bag --model type.yaml",
       {"type.yaml:2:", "unknown type 'backlsh'; did you mean 'backlash'?"}},
      {"calibrate s.bag --model map.yaml", {"map.yaml:2:", "not YAML", "look there and on the line before"}},
      {"promote s.bag --store kept", {"s.bag", "is a session's bag, not a calibration"}},
      {"report s.bag --calibration c.yaml --plotly plotly.js -o page.csv",
       {"-o page.csv", "a report page", ".csv", "--force"}},
      {"apply semicolons.csv --calibration c.yaml -o out.csv",
       {"semicolons.csv", "separated by commas", "mm import"}},
      {"simulate --machine three_axis --plan plan.yaml --rough stormy -o o.bag", {"stormy"}},
      {"export c.yaml --to linuxcnd -o out", {"linuxcnd", "'linuxcnc'", "heidenhain"}},
      {"export c.yaml --to linuxcnc -o c.yaml", {"c.yaml", "not a folder"}},
      {"export none.yaml --to csv -o out", {"none.yaml"}},
      {"export s.bag --to csv -o out", {"s.bag"}},
      {"export c.yaml --to csv -o none/out", {"'none'"}},
      {"export c.yaml --to csv -o .", {"is not from an export"}},
      {"export c.yaml --to csv -o out --axis q=x", {"'q'", "x, y, z"}},
      {"export c.yaml --to csv -o out --axis x", {"'x'", "table=x"}},
      {"export c.yaml --to csv -o out --axis x=spindle", {"'spindle'"}},
      {"export c.yaml --to fanuc -o out --detection-unit-um 0", {"--detection-unit-um", "'0'"}},
      {"export c.yaml --to fanuc -o out --detection-unit-um 0.07", {"--detection-unit-um 0.07", "1820"}},
      {"export c.yaml --to fanuc -o out --rapid-mm-min 0", {"--rapid-mm-min", "'0'"}},
      {"history --compare c.yaml active --store filled --json", {"--json", "--compare", "--trend"}},
      {"mm-benchmark --plan none.yaml", {"none.yaml"}},
      {"mm-benchmark --plan plan.yaml --only gremlin --trials 1", {"gremlin"}},
      {"machine new -o new.urdf", {"--axis"}},
      {"machine new --axis x -o new.urdf", {"'x'", "x=-20:20mm"}},
      {"machine new --axis x=20:-20mm -o new.urdf", {"'x'", "lower"}},
      {"machine new --axis x=0:20in -o new.urdf", {"mm"}},
      {"machine new --axis x=0:20mm --axis x=0:20mm -o new.urdf", {"'x'", "twice"}},
      {"machine new --axis b=-90:90deg -o new.urdf", {"direction"}},
      {"machine new --axis b=-90:90deg@0,0,0 -o new.urdf", {"direction", "zero"}},
      {"machine new --axis x=0:nanmm -o new.urdf", {"x=0:nanmm"}},
      {"machine new --axis x=0:20mm --tip-mm 0,0 -o new.urdf", {"--tip-mm", "0,0"}},
      {"machine new --axis x=0:20mm --speed-mm-s 0 -o new.urdf", {"--speed-mm-s", "'0'"}},
      {"machine new --axis x=0:20mm --probe nose -o new.urdf", {"--probe", "touch"}},
      {"machine new --axis x=0:20mm --lead y=5mm -o new.urdf --model new.yaml", {"--lead", "'y'"}},
      {"machine new --axis x=0:20mm --lead x=5deg -o new.urdf --model new.yaml", {"x=5deg", "x=5mm"}},
      {"machine new --axis x=0:20mm --lead x=0mm -o new.urdf --model new.yaml", {"positive"}},
      {"machine new --axis x=0:20mm --lead x=5mm -o new.urdf", {"--lead", "--model"}},
      {"plan new --machine three_axis -o p.yaml", {"--balls", "--positions"}},
      {"plan new --machine three_axis --balls 3x3 --positions 5 -o p.yaml", {"only one"}},
      {"plan new --machine three_axis --test rotary -o p.yaml", {"--test rotary", "needs a rotary joint"}},
      {"plan new --machine three_axis --test circular --hours 3 -o p.yaml", {"--hours", "circular"}},
      {"plan new --machine three_axis --balls 3x3 --hours 3 -o p.yaml", {"--hours", "--test"}},
      {"plan new --machine three_axis --balls 3by3 -o p.yaml", {"3by3", "3x3"}},
      {"plan new --machine three_axis --balls 3x3 --ball-radius-mm 30 -o p.yaml", {"30", "--ball-radius-mm"}},
      {"plan new --machine three_axis --balls 0x3 -o p.yaml", {"0x3"}},
      {"plan new --machine three_axis --balls 3x3 --points 2 -o p.yaml", {"--points", "'2'"}},
      {"plan new --machine three_axis --artifact none.yaml -o p.yaml", {"none.yaml"}},
      {"plan new --machine lathe --balls 3x3 -o p.yaml", {"lathe"}},
      {"completion fish", {"fish", "bash"}},
      {"manual nothing", {"nothing", "--list"}}};
  return all;
}

TEST_F(Refusals, OneLineAndNothingLost) {
  EXPECT_GE(rows().size(), 60u);
  for (const Row& row : rows()) expectRefused(row.typed, row.words);
}

TEST_F(Refusals, AnotherMachineIsPromotedOnlyByForce) {
  run("promote c.yaml --store forced");
  run("promote t.yaml --store forced");  // the same machine
  EXPECT_EQ(typed("promote twin_c.yaml --store forced").status, 2);
  const Answer forced = typed("promote twin_c.yaml --store forced --force");
  EXPECT_EQ(forced.status, 0) << forced.error;
}

// A disk that does not give a file: reading /proc/self/mem from its beginning is EIO.
TEST_F(Refusals, NothingTakesThePlaceOfWhatTheDiskDoesNotGive) {
  namespace fs = std::filesystem;
  run("promote c.yaml --store unread");
  const fs::path store = *folder_ / "unread", file = store / fs::read_symlink(store / "active");
  fs::remove(file);
  fs::create_symlink("/proc/self/mem", file);
  const Answer refused = typed("promote twin_c.yaml --store unread");
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.error.find("Input/output error"), std::string::npos) << refused.error;
  const Answer forced = typed("promote twin_c.yaml --store unread --force");
  EXPECT_EQ(forced.status, 0) << forced.error;
  fs::remove_all(store);
}

TEST_F(Refusals, ADamagedBagIsReadUpToTheDamageAndSaysSo) {
  const Answer answer = typed("check cut.bag");
  EXPECT_EQ(answer.status, 0) << answer.error;
  for (const char* words : {"cut.bag: damaged or truncated at byte", "read up to there"})
    EXPECT_NE(answer.error.find(words), std::string::npos) << answer.error;
}

}  // namespace
}  // namespace mm

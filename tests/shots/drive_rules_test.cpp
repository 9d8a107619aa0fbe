#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::HasSubstr;

std::string drive_refusal(const std::string& lines) {
  return refusal(load_with("\n[[drive]]\nwhere = { expression = \"X > 0\" }\n" + lines));
}

TEST(DriveRules, ADriveIsAcceptedWithKeysWithAColliderOrWithNeither) {
  EXPECT_EQ(drive_refusal(""), "accepted") << "it holds its nodes where they rest";
  EXPECT_EQ(drive_refusal("keys = [{ time = 0 }, { time = 1, axis = \"x\", degrees = 450 }]\n"), "accepted");
  EXPECT_EQ(drive_refusal("collider = \"wheel\"\n[[collider]]\nname = \"wheel\"\nplane = { height = 0 }\n"),
            "accepted");
  EXPECT_THAT(drive_refusal("collider = \"weel\"\n[[collider]]\nname = \"wheel\"\nplane = { height = 0 }\n"),
              HasSubstr("'wheel'"));
  EXPECT_THAT(drive_refusal("collider = \"wheel\"\nkeys = [{ time = 0 }]\n[[collider]]\nname = \"wheel\"\nplane = { "
                            "height = 0 }\n"),
              HasSubstr("keep one of the two"));
}

TEST(DriveRules, KeysOutOfOrderAreRefusedWithTheKeyBefore) {
  const std::string refused = drive_refusal("keys = [{ time = 0 }, { time = 2 }, { time = 1 }]\n");
  EXPECT_THAT(refused, HasSubstr("= 1: expected more than"));
  EXPECT_THAT(refused, HasSubstr("t.toml:"));
  EXPECT_THAT(drive_refusal("keys = [{ time = 1 }, { time = 1 }]\n"), HasSubstr("= 1: expected more than"));
}

TEST(DriveRules, StiffnessGoesWithSoftDrives) {
  EXPECT_THAT(drive_refusal("method = \"soft\"\n"), HasSubstr("stiffness is missing"));
  EXPECT_EQ(drive_refusal("method = \"soft\"\nturning_stiffness = 2\n"), "accepted");
  EXPECT_THAT(drive_refusal("stiffness = 2\n"), HasSubstr("only soft drives have it"));
  EXPECT_THAT(drive_refusal("method = \"soft\"\nstiffness = -2\n"), HasSubstr("expected a stiffness >= 0"));
}

TEST(DriveRules, SomethingIsDriven) {
  EXPECT_THAT(drive_refusal("drive = []\n"), HasSubstr("drive"));
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "\"micropolar\"", "\"stvk\"") +
                                "\n[[drive]]\nwhere = { expression = \"X > 0\" }\ndrive = [\"microrotations\"]\n")),
              HasSubstr("has no microrotations"));
}

TEST(DriveRules, LoadsPushOrTurnWhatTheyCan) {
  EXPECT_THAT(refusal(load_with("\n[[load]]\n")), HasSubstr("force is missing"));
  EXPECT_EQ(refusal(load_with("\n[[load]]\ntorque = { x = \"sin(t)\" }\n")), "accepted");
  EXPECT_THAT(
      refusal(load_text(replaced(SMALL_SHOT, "\"micropolar\"", "\"stvk\"") + "\n[[load]]\ntorque = { x = 1 }\n")),
      HasSubstr("no microrotations that a torque could turn"));
}

TEST(DriveRules, MeasuresAlongAnAxisNameOne) {
  EXPECT_THAT(refusal(load_with("\n[[measure]]\nname = \"m\"\nkind = \"reaction_torque\"\n")),
              HasSubstr("axis is missing"));
  EXPECT_THAT(refusal(load_with("\n[[measure]]\nname = \"m\"\nkind = \"curve_radius\"\naxis = \"x\"\n")),
              HasSubstr("has no axis"));
}

TEST(DriveRules, ExponentialRotationsGoWithBackwardEuler) {
  EXPECT_EQ(refusal(load_with("\n[fem]\nrotation_update = \"exponential\"\n")), "accepted");
  EXPECT_THAT(refusal(load_with("\n[fem]\nrotation_update = \"exponential\"\nintegrator = \"bdf2\"\n")),
              HasSubstr("the same to their order"));
}

} // namespace
} // namespace wry::shots

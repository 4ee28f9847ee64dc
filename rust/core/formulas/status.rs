//! Why a point has no value. A value is NaN exactly where its status is not ok.

macro_rules! statuses {
    ($($id:ident $code:literal $name:literal $sentence:literal;)+) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Status { $($id = $code),+ }

        impl Status {
            pub const ALL: &'static [Status] = &[$(Status::$id),+];

            pub fn name(self) -> &'static str {
                match self { $(Status::$id => $name),+ }
            }

            pub fn sentence(self) -> &'static str {
                match self { $(Status::$id => $sentence),+ }
            }
        }
    };
}

statuses! {
    Ok 0 "ok" "the value holds";
    SlidesBack 1 "slides_back" "the anchors slide back down the slope under their own weight";
    SlidesDown 2 "slides_down" "the anchors slide forward down the slope under their own weight";
    NothingAnchored 3 "nothing_anchored" "every segment moves at once, none is left as an anchor";
    NoRoomAhead 4 "no_room_ahead" "more anchors are asked for ahead of the moving block than there are";
    AnchorsTooWeak 5 "anchors_too_weak" "the anchors cannot hold the force that the moving segments need";
    DriveTooWeak 6 "drive_too_weak" "the drive cannot overcome friction and weight of the moving segments";
    NoOptimum 7 "no_optimum" "there is no best segment count: fewer segments are always faster";
    Unbounded 8 "unbounded" "the value grows without limit (nothing opposes it)";
    SetValued 9 "set_valued" "at rest friction takes any value up to break-away";
    NoneFeasible 10 "none_feasible" "no value of the axis that was folded away works";
    CannotBrake 11 "cannot_brake" "the anchors cannot brake the moving segments to rest";
    EmptyRange 12 "empty_range" "no segment count lies between segments_min and segments_max";
    NotFinite 13 "not_finite" "the formula has no finite value here";
    NotReached 14 "not_reached" "the run ends before the stroke is complete";
    Unresolved 15 "unresolved" "events or changes follow too closely to be resolved";
    Diverged 16 "diverged" "the trajectory leaves all bounds: a smaller time_step may keep it";
    TooManySegments 17 "too_many_segments" "the whole robot is simulated up to 32 segments";
    NoPhaseTime 18 "no_phase_time" "the phases of the gait have no duration: give a speed_limit or a dwell";
    TooManySteps 19 "too_many_steps" "the run would take too many steps, or events follow each other without end";
    MixedJoints 20 "mixed_joints" "some joints of the robot are ideal and others elastic";
    NoClosedForm 21 "no_closed_form" "a brake, viscosity or a speed limit acts that the closed form leaves out: simulate the robot";
    EnergyOpen 22 "energy_open" "the energy balance of the run does not close: a smaller time_step may close it";
    SupplyTooWeak 23 "supply_too_weak" "the motor's supply cannot deliver the force of an elastic joint at the speed of its drive";
    ElasticJointsOnly 24 "elastic_joints_only" "Stribeck friction and build-up of a whole robot need elastic joints: give a joint_stiffness";
}

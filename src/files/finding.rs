//! Problems of a URDF file, each with a name, a place and a remedy.

use std::fmt;
use std::path::Path;

/// Name of what was found. Kinds whose [`is_warning`](Self::is_warning) holds do not stop the reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FindingKind {
    /// The root element is not `<robot>`.
    NotUrdf,
    /// Macros of xacro that nobody expanded.
    UnexpandedXacro,
    /// Not well-formed XML.
    Xml,
    /// Larger, deeper or with more elements than any robot.
    TooLarge,
    /// An element lacks a name, a type or a link.
    MissingPart,
    /// A text that should be numbers is none.
    BadNumber,
    /// NaN or infinity.
    NotFinite,
    /// Two links of one name.
    DuplicateLink,
    /// Two joints of one name.
    DuplicateJoint,
    /// A joint or closure names a link that does not exist.
    UnknownLink,
    /// A setting names a joint that does not exist.
    UnknownJoint,
    /// An axis of length zero.
    ZeroAxis,
    /// A joint type that is not known, or that has no place in a leg.
    UnsupportedJointType,
    /// More than one link without a parent.
    SeveralRoots,
    /// Links that no walk from the root reaches.
    CyclicParents,
    /// No leg reaches the link that is named as the platform.
    DisconnectedPlatform,
    /// An arm and not a parallel mechanism.
    SerialChain,
    /// A tree in which no loop is closed.
    NoLoopClosures,
    /// A closing frame without its partner.
    UnpairedClosingFrame,
    /// A closing pair names what does not exist.
    UnknownClosureLink,
    /// Two statements close the same loop in different places.
    ConflictingClosures,
    /// Both ends of a closure are on one rigid body.
    ClosureWithinOneBody,
    /// A closure of unknown kind.
    UnknownClosureType,
    /// Fewer than six legs.
    TooFewLegs,
    /// More than six legs.
    TooManyLegs,
    /// A leg without an actuated slide.
    LegWithoutSlide,
    /// A leg with more than one slide.
    LegWithTwoSlides,
    /// The slide of a leg only follows another joint.
    MimicSlide,
    /// A leg with branches or loops of its own.
    LegBranches,
    /// A leg whose joints leave the platform too little or too much freedom.
    LegMobility,
    /// Every leg is driven by turning joints.
    NoPrismaticActuators,
    /// The slide is fixed on the base or on the platform.
    SlideOnBase,
    /// Several bodies could be the platform.
    AmbiguousPlatform,
    /// The joints of one end of a leg have no common point, since there are too few.
    AnchorUndetermined,
    /// The joint axes of one end of a leg miss each other.
    JointAxesDoNotMeet,
    /// The slide does not move along the line of the anchors.
    SlideOffLeg,
    /// A slide without limits.
    NoLimit,
    /// Limits that leave no travel or no length.
    EmptyRange,
    /// A setting that does not fit the file.
    BadSetting,
    /// At its zero pose the file is not assembled; the home pose was found from the lengths.
    HomeNotClosed,
    /// A slide stands outside its limits at home.
    HomeOutsideLimits,
    /// The legs hardly hold the platform at home.
    SingularHome,
    /// A joint or closure without the direction of its axis.
    DefaultAxis,
    /// An attribute that is not read, in an element whose attributes place something.
    UnknownAttribute,
    /// Closures that state their place in one of their links only.
    PlaceTakenAtHome,
    /// By their names, base and platform are not what their place in the tree makes them.
    SwappedNames,
    /// Something of the file was chosen or passed over.
    Note,
}

impl FindingKind {
    /// True for what the user should know although the file is read.
    pub fn is_warning(self) -> bool {
        use FindingKind as K;
        matches!(
            self,
            K::HomeNotClosed
                | K::HomeOutsideLimits
                | K::SingularHome
                | K::DefaultAxis
                | K::UnknownAttribute
                | K::PlaceTakenAtHome
                | K::SwappedNames
                | K::Note
        )
    }
}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

/// One thing that is wrong, or worth knowing.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Finding {
    /// Kind of problem.
    pub kind: FindingKind,
    /// Name of the link, joint or closure; empty if it is about the whole file.
    pub element: String,
    /// Line of the element, from 1.
    pub line: Option<usize>,
    /// The problem and its remedy.
    pub text: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        write!(f, "{}: {}", self.kind, self.text)
    }
}

/// More warnings than this are not kept, nor more errors shown: a file with so many has one cause.
pub(super) const KEPT: usize = 100;

/// Findings line by line, each with its file; of many the first, and how many more there are.
pub(super) fn findings_text(path: &Path, findings: &[Finding]) -> String {
    let path = path.display();
    let mut lines: Vec<String> = findings.iter().take(KEPT).map(|f| format!("{path}: {f}")).collect();
    if findings.len() > KEPT {
        lines.push(format!("{path}: {} more errors are not shown; correct those that are", findings.len() - KEPT));
    }
    lines.join("\n")
}

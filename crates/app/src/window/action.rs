//! What can be done, with its name for people.

use super::model::Numbers;
use super::model::{Arrangement, Edit, FocusMode, Inside, PaneId, PictureKind, PictureSize, Preference, Theme};
use defocus::stereo::Layout;
use eframe::egui::KeyboardShortcut;

/// Something to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Ask for a scene, an image or a state.
    Open,
    /// Open what this names.
    OpenNamed(String),
    /// Ask for a file to keep the state in.
    SaveState,
    /// Ask for a file for a pane's picture.
    SavePicture(PaneId, PictureKind),
    /// Ask for a file for the comparison of all panes.
    SaveReport,
    /// A pane's picture to the clipboard.
    CopyImage(PaneId),
    /// The command line that makes this picture to the clipboard.
    CopyCommand,
    /// Take back the last change.
    Undo,
    /// Make it again.
    Redo,
    /// Show or hide the command palette.
    Palette,
    /// Show or hide the sheet of keys.
    Help,
    /// One more pane.
    AddPane,
    /// A copy of a pane.
    Duplicate(PaneId),
    /// Take a pane away.
    ClosePane(PaneId),
    /// Two panes side by side: another one and the truth.
    Compare,
    /// How panes lie.
    Arrange(Arrangement),
    /// All panes side by side and about the same size.
    ResetPanes,
    /// Make a pane A.
    ChooseA(PaneId),
    /// Make a pane B.
    ChooseB(PaneId),
    /// Exchange A and B.
    Swap,
    /// Give a pane a method.
    SetMethod(PaneId, String),
    /// All parameters of a pane's method as they were.
    ResetParams(PaneId),
    /// What a pane shows, by its place in the list.
    SetShow(PaneId, usize),
    /// Show what a pane's method tells of each pixel.
    LookInside(PaneId, Inside),
    /// Time the passes of pane A's method.
    TimePasses,
    /// Figures also without a pane that shows the reference.
    Measure,
    /// The whole picture, or pixel for pixel.
    ToggleZoom,
    /// This magnification.
    ZoomTo(f32),
    /// How large the picture is.
    SetSize(PictureSize),
    /// The camera as the scene has it.
    ResetCamera,
    /// A lens by its preset's name.
    SetLens(String),
    /// A lens that suits the scene.
    SuitLens,
    /// What decides where the lens is focused.
    SetFocusMode(FocusMode),
    /// Two eyes' pictures shown this way; one eye without.
    SetStereo(Option<Layout>),
    /// Light, dark, or as the system has it.
    SetTheme(Theme),
    /// Read shaders again whenever one is saved.
    WatchShaders,
    /// Ask what goes into figures for a paper.
    FiguresForPaper,
    /// Ask for a file for numbers.
    SaveNumbers(Numbers),
    /// Tell what every texture of the method under the pointer holds, or stop.
    Story,
    /// Show the point spread function of pane A's method.
    Kernel,
    /// Show or hide the batch.
    Batch,
    /// Read the scene's file with so many metres a unit of length.
    ScaleScene(f64),
    /// A pane beside another that is drawn with the shaders as the program was built.
    CompareBuilds(PaneId),
    /// The picture alone with a strip of aperture and focus, or everything.
    TogglePanels,
    /// The window over the whole screen, or not.
    ToggleFullScreen,
    /// The interface so many times as large as it normally is.
    ScaleInterface(f32),
    /// Open the aperture by so many steps; close it by negative ones.
    NudgeAperture(i8),
    /// Focus nearer by so many steps, or farther by negative ones.
    NudgeFocus(i8),
    /// Begin the lesson of that place, from 0.
    Lesson(usize),
    /// Go on in the lessons by so many.
    StepLesson(i8),
    /// Back to what was shown before the lessons.
    EndLesson,
    /// Play the scene's animation, or stop it.
    PlayAnimation,
    /// Ask for an image to be the aperture.
    OpenAperture,
    /// Change one part of what is shown.
    Edit(Edit),
    /// Change one of the person's choices.
    Prefer(Preference),
}

impl From<Edit> for Action {
    fn from(edit: Edit) -> Self {
        Self::Edit(edit)
    }
}

/// An action with its name for people.
pub struct Command {
    /// What it is called.
    pub name: String,
    /// The keys that do it.
    pub keys: Option<KeyboardShortcut>,
    /// What it does.
    pub action: Action,
}

//! Pictures that take long, drawn beside the interface: on a thread, on a device of its own,
//! so that nothing that the interface draws waits behind them.

use super::Wake;
use super::progress::{Progressive, passed_power_of_two, progressive};
use super::request::RenderRequest;
use super::views::{Views, Which};
use crate::window::model::KernelChoice;
use defocus::gpu::{Frame, Gpu, PassTime, Texture, download};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::{SurfaceOptions, View};
use defocus_study::psf::{self, Psf};
use defocus_study::steps::Steps;
use defocus_study::timing::RunTimes;
use defocus_study::{GpuSource, Source, StudyError};
use glam::Vec3;
use std::collections::{BTreeSet, VecDeque};
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A picture that converges is shown at least so often: reading it back costs time too.
const SHOWN_EVERY: Duration = Duration::from_secs(1);

/// What a picture is drawn from.
#[derive(Clone)]
pub(super) struct Subject {
    /// Which scene and shaders: another number for others.
    pub world: u64,
    pub source: Source,
    pub options: SurfaceOptions,
    pub render: RenderRequest,
}

/// A picture to be drawn.
pub(super) struct Job {
    pub ticket: u64,
    pub subject: Subject,
    pub method: Box<dyn Method>,
    /// Whether it is drawn with the shaders that the program was built with.
    pub as_built: bool,
    pub work: Work,
}

/// What is to be done with a job's method.
#[derive(Clone, Copy)]
pub(super) enum Work {
    /// Its picture.
    Picture,
    /// So many runs to time the passes of, the first of which does not count.
    TimePasses(u32),
    /// Its point spread function with the lens's aperture, whatever the scene.
    Kernel(KernelChoice),
}

enum Order {
    Draw(Box<Job>),
    Shader(String, String),
}

/// What the lane tells.
pub(super) enum Told {
    /// Lens points that a picture has and will have.
    Progress(u32, u32),
    /// A picture, or a stage of one that converges.
    Picture(Drawn),
    /// Median times of the passes over several runs.
    Times(Vec<PassTime>),
    /// A point spread function.
    Kernel(Box<Psf>),
    /// Why there is none.
    Failed(String),
}

/// A picture.
pub(super) struct Drawn {
    pub color: Arc<ColorImage>,
    /// Lens points, of one that converges.
    pub samples: Option<u32>,
    pub is_done: bool,
    /// Elapsed time of the method, or of one view, ms.
    pub ms: f64,
}

/// Numbers of the pictures that are still wanted.
type Wanted = Arc<Mutex<BTreeSet<u64>>>;

/// The thread, as the engine sees it.
pub(super) struct Lane {
    orders: Sender<Order>,
    told: Receiver<(u64, Told)>,
    wanted: Wanted,
}

impl Lane {
    /// Starts the thread; its device is opened with the first picture, on the adapter of
    /// that name.
    pub fn start(adapter: String, wake: Wake) -> Self {
        let (orders, received) = channel();
        let (sender, told) = channel();
        let wanted = Wanted::default();
        let tell = move |ticket, what| {
            // Nobody listens any more where the window was closed meanwhile.
            let _ = sender.send((ticket, what));
            wake.call();
        };
        let worker =
            Worker { adapter, wanted: wanted.clone(), shaders: Vec::new(), bench: None, built: None, runs: Vec::new() };
        std::thread::spawn(move || worker.work(&received, &tell));
        Self { orders, told, wanted }
    }

    /// Draws a picture; nothing else that was ordered under this ticket's owner is touched.
    pub fn draw(&self, job: Job) {
        self.with_wanted(|wanted| wanted.insert(job.ticket));
        // The thread ends only with this side.
        let _ = self.orders.send(Order::Draw(Box::new(job)));
    }

    /// A picture is not wanted any more.
    pub fn give_up(&self, ticket: u64) {
        self.with_wanted(|wanted| wanted.remove(&ticket));
    }

    /// Has the thread use another source for a shader.
    pub fn replace_shader(&self, name: &str, source: &str) {
        let _ = self.orders.send(Order::Shader(name.into(), source.into()));
    }

    /// What was told since the last call.
    pub fn told(&self) -> Vec<(u64, Told)> {
        self.told.try_iter().collect()
    }

    fn with_wanted<R>(&self, change: impl FnOnce(&mut BTreeSet<u64>) -> R) {
        // A poisoned set belongs to a thread that has ended.
        if let Ok(mut wanted) = self.wanted.lock() {
            change(&mut wanted);
        }
    }
}

/// The device with what was uploaded to it.
struct Bench {
    gpu: Gpu,
    subject: Option<(u64, GpuSource)>,
    views: Views,
}

/// A picture that converges.
struct Running {
    ticket: u64,
    as_built: bool,
    render: RenderRequest,
    progressive: Progressive,
    prefix: String,
    steps: Steps,
    shown: Option<u32>,
    shown_at: Instant,
}

struct Worker {
    adapter: String,
    wanted: Wanted,
    shaders: Vec<(String, String)>,
    bench: Option<Bench>,
    /// One whose shaders are those that the program was built with.
    built: Option<Bench>,
    runs: Vec<Running>,
}

impl Worker {
    fn work(mut self, orders: &Receiver<Order>, tell: &dyn Fn(u64, Told)) {
        let mut jobs: VecDeque<Job> = VecDeque::new();
        loop {
            let is_idle = jobs.is_empty() && self.runs.is_empty();
            // Waits only where there is nothing to do; ends with the window.
            let first = if is_idle { orders.recv().ok() } else { None };
            if is_idle && first.is_none() {
                return;
            }
            for order in first.into_iter().chain(orders.try_iter()) {
                match order {
                    Order::Draw(job) => jobs.push_back(*job),
                    Order::Shader(name, source) => self.take_shader(name, source),
                }
            }
            let wanted = self.wanted.clone();
            let is_wanted = |ticket: u64| wanted.lock().is_ok_and(|wanted| wanted.contains(&ticket));
            jobs.retain(|job| is_wanted(job.ticket));
            self.runs.retain(|run| is_wanted(run.ticket));
            // What is done in one go comes before what converges.
            match jobs.pop_front() {
                Some(job) => self.begin(&job, tell),
                None => self.go_on(tell),
            }
        }
    }

    fn take_shader(&mut self, name: String, source: String) {
        if let Some(bench) = &mut self.bench {
            // The interface's own device refused or took it before.
            let _ = bench.gpu.replace_shader(&name, &source);
            bench.views = Views::default();
        }
        self.shaders.push((name, source));
    }

    fn begin(&mut self, job: &Job, tell: &dyn Fn(u64, Told)) {
        let told = match job.work {
            Work::Picture => self.draw(job).map(|drawn| drawn.map(Told::Picture)),
            Work::TimePasses(runs) => self.time(job, runs).map(|times| Some(Told::Times(times))),
            Work::Kernel(choice) => self.measure(job, choice).map(|psf| psf.map(|psf| Told::Kernel(Box::new(psf)))),
        };
        match told {
            Ok(Some(told)) => tell(job.ticket, told),
            Ok(None) => {}
            Err(error) => tell(job.ticket, Told::Failed(error)),
        }
    }

    fn bench(&mut self, as_built: bool) -> Result<&mut Bench, String> {
        let (bench, shaders): (_, &[_]) =
            if as_built { (&mut self.built, &[]) } else { (&mut self.bench, &self.shaders) };
        match bench {
            Some(bench) => Ok(bench),
            empty => Ok(empty.insert(Bench::open(&self.adapter, shaders)?)),
        }
    }

    /// Measures a point spread function; `None` if it is not wanted any more.
    fn measure(&mut self, job: &Job, choice: KernelChoice) -> Result<Option<Psf>, String> {
        let wanted = self.wanted.clone();
        let gpu = self.bench(job.as_built)?.gpu.clone();
        let lens = Lens { aperture: job.subject.render.lens.aperture.clone(), ..Lens::PINHOLE };
        let mut progress = |_: defocus_study::Step<'_>| match wanted.lock() {
            Ok(wanted) if !wanted.contains(&job.ticket) => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let of = (&[choice.coc_px][..], choice.side());
        match psf::measure(&gpu, &lens, std::slice::from_ref(&job.method), of, &mut progress) {
            Ok(found) => Ok(found.into_iter().next()),
            Err(StudyError::Stopped) => Ok(None),
            Err(error) => Err(error.to_string()),
        }
    }

    /// Times the passes of a picture.
    fn time(&mut self, job: &Job, timed_runs: u32) -> Result<Vec<PassTime>, String> {
        let lens = &job.subject.render.lens;
        let (gpu, view) = self.bench(job.as_built)?.view(&job.subject)?;
        let mut frame = gpu.frame();
        view.pinhole(&mut frame);
        view.z_bounds(&mut frame);
        frame.finish().timings.wait();
        let mut runs = Vec::new();
        for run in 0..=timed_runs {
            let mut frame = gpu.timed_frame();
            methods::record(job.method.as_ref(), &mut frame, view, lens).map_err(|e| e.to_string())?;
            let passes = frame.finish().timings.wait();
            // The first builds pipelines and fills pools.
            if run > 0 {
                runs.push(passes);
            }
        }
        Ok(medians(&runs))
    }

    /// Draws a picture; `None` of one that converges, which is begun.
    fn draw(&mut self, job: &Job) -> Result<Option<Drawn>, String> {
        let lens = &job.subject.render.lens;
        let (gpu, view) = self.bench(job.as_built)?.view(&job.subject)?;
        // The pinhole image before all else: no method's time has it.
        let mut frame = gpu.frame();
        view.pinhole(&mut frame);
        view.z_bounds(&mut frame);
        let progressive = progressive(job.method.as_ref(), &mut frame, view, lens);
        frame.finish().timings.wait();
        if let Some(progressive) = progressive {
            self.runs.push(Running {
                ticket: job.ticket,
                as_built: job.as_built,
                render: job.subject.render.clone(),
                progressive,
                prefix: format!("{}/", job.method.about().id),
                steps: Steps::default(),
                shown: None,
                shown_at: Instant::now(),
            });
            return Ok(None);
        }
        let start = Instant::now();
        let mut frame = gpu.frame();
        let texture = methods::record(job.method.as_ref(), &mut frame, view, lens).map_err(|e| e.to_string())?;
        frame.finish().timings.wait();
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let color = Arc::new(download(&gpu, &texture));
        Ok(Some(Drawn { color, samples: None, is_done: true, ms }))
    }

    /// Adds lens points to the oldest picture that converges.
    fn go_on(&mut self, tell: &dyn Fn(u64, Told)) {
        let Some(run) = self.runs.first_mut() else { return };
        let bench = if run.as_built { &mut self.built } else { &mut self.bench };
        let Some(bench) = bench else { return };
        let ticket = run.ticket;
        let gpu = bench.gpu.clone();
        let result = match bench.views.of(&run.render) {
            Some(view) => run.step(&gpu, view),
            None => Err("the view of a picture that converges is gone; change something to start it again".into()),
        };
        let (count, samples) = (run.progressive.run.count(), run.progressive.samples);
        if result.is_err() || count >= samples {
            self.runs.remove(0);
        }
        match result {
            Ok(drawn) => {
                tell(ticket, Told::Progress(count, samples));
                if let Some(drawn) = drawn {
                    tell(ticket, Told::Picture(drawn));
                }
            }
            Err(error) => tell(ticket, Told::Failed(error)),
        }
    }
}

impl Bench {
    fn open(adapter: &str, shaders: &[(String, String)]) -> Result<Self, String> {
        let gpu = Gpu::open(Some(adapter)).map_err(|e| e.to_string())?;
        for (name, source) in shaders {
            // As in `Worker::take_shader`.
            let _ = gpu.replace_shader(name, source);
        }
        Ok(Self { gpu, subject: None, views: Views::default() })
    }

    /// The view that a picture is drawn from.
    fn view(&mut self, subject: &Subject) -> Result<(Gpu, &mut View), String> {
        let known = self.subject.take().filter(|(world, _)| *world == subject.world);
        let (_, source) = match known {
            Some(known) => self.subject.insert(known),
            None => {
                self.views = Views::default();
                self.subject.insert((subject.world, subject.source.upload(&self.gpu, subject.options)))
            }
        };
        self.views.prepare(source, &subject.render, Which::Full).map_err(|e| e.to_string())?;
        let view = self.views.of(&subject.render).ok_or("the view cannot be made; change something to try again")?;
        Ok((self.gpu.clone(), view))
    }
}

impl Running {
    /// Adds as many lens points as there is time for; the picture if it is worth showing.
    fn step(&mut self, gpu: &Gpu, view: &mut View) -> Result<Option<Drawn>, String> {
        let start = Instant::now();
        let Progressive { run, samples } = &mut self.progressive;
        let before = run.count();
        let views = self.steps.next(*samples - before);
        let mut frame: Frame<'_> = gpu.frame();
        frame.set_prefix(self.prefix.clone());
        run.advance(&mut frame, view, &self.render.lens, views).map_err(|e| e.to_string())?;
        let count = run.count();
        let is_done = count >= *samples;
        let is_worth = is_done || passed_power_of_two(self.shown, count) || self.shown_at.elapsed() >= SHOWN_EVERY;
        let mean = is_worth.then(|| run.mean(&mut frame));
        frame.finish().timings.wait();
        self.steps.took(count - before, start.elapsed());
        let Some(mean) = mean else { return Ok(None) };
        (self.shown, self.shown_at) = (Some(count), Instant::now());
        let color = Arc::new(download(gpu, &mean));
        let ms = self.steps.ms_per_unit();
        Ok(Some(Drawn { color, samples: Some(count), is_done, ms }))
    }
}

/// Median time of each pass over several runs, in the order of the passes; passes of one
/// label are added up.
fn medians(runs: &[Vec<PassTime>]) -> Vec<PassTime> {
    let mut labels: Vec<&str> = Vec::new();
    for pass in runs.iter().flatten() {
        if !labels.contains(&pass.label.as_str()) {
            labels.push(&pass.label);
        }
    }
    let of_run = |run: &Vec<PassTime>, label: &str| run.iter().filter(|p| p.label == label).map(|p| p.ms).sum();
    let median = |label: &&str| {
        let times: Vec<f64> = runs.iter().map(|run| of_run(run, label)).collect();
        let ms = RunTimes::of(&times).map_or(0.0, |times| times.median);
        PassTime { label: (*label).to_owned(), ms }
    };
    labels.iter().map(median).collect()
}

/// A picture that another device has drawn, as a texture of this one: RGBA32F, which holds
/// every value of both formats that methods have.
pub(super) fn upload(gpu: &Gpu, color: &ColorImage) -> Texture {
    let texture = gpu.texture("picture from beside", color.size, wgpu::TextureFormat::Rgba32Float);
    let texels: Vec<[f32; 4]> = color.pixels.iter().map(|Vec3 { x, y, z }| [*x, *y, *z, 1.0]).collect();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * color.size.x), rows_per_image: None };
    let size = wgpu::Extent3d { width: color.size.x, height: color.size.y, depth_or_array_layers: 1 };
    gpu.queue().write_texture(texture.raw().as_image_copy(), bytemuck::cast_slice(&texels), layout, size);
    texture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_one_label_are_added_and_the_median_of_runs_is_taken() {
        let pass = |label: &str, ms| PassTime { label: label.into(), ms };
        let run = |ms| vec![pass("blur", ms), pass("mix", 1.0), pass("blur", 2.0 * ms)];
        let told = medians(&[run(1.0), run(100.0), run(2.0)]);
        assert_eq!(told, [pass("blur", 6.0), pass("mix", 1.0)]);
    }
}
